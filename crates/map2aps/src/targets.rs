//! Learning targets of a data set's labels, alike for whoever trains on them and whoever scores against them.

use aps_data::{Dataset, MapData, MapEntry, Part, Profile, Samples};
use aps_label::{MeanStd, Moments, Normalization, NormalizationError, Protocol, relative_power};
use rayon::prelude::*;

use crate::error::{At, Place, Result};
use crate::maps::MapError;
use crate::overview::pooled;
use crate::scores::{Domain, ScoreError};

/// The protocol the labels were made under, if that is known.
pub fn protocol_of(dataset: &Dataset) -> Option<Protocol> {
    let configuration = &dataset.manifest().configuration;
    configuration["label"]["protocol"].as_str()?.parse().ok()
}

/// Protocol of the labels, statistics of the training maps, and the learning target that both define. The training maps are
/// those of the data set's split, whichever of them are then trained on.
///
/// # Errors
/// A data set that cannot be read, stores no angle power spectra, has no label in its training maps, or flat ones that give nothing
/// to normalise by.
pub fn learning_target(dataset: &Dataset) -> Result<(Protocol, MeanStd, Target)> {
    dataset.aps_layout()?;
    let protocol = protocol_of(dataset).unwrap_or_default();
    let train = training_statistics(dataset)?;
    let target = Target::Normalised(Normalization::of(protocol, train));
    Ok((protocol, train, target))
}

/// Number of labelled links of some maps, by the manifest.
pub fn labelled_links(dataset: &Dataset, maps: &[u32]) -> usize {
    let entries = dataset.manifest().maps.iter();
    let valid = entries
        .filter(|entry| maps.contains(&entry.id))
        .map(MapEntry::valid);
    valid.sum::<u64>() as usize
}

/// The maps of one part of a data set, at least one.
///
/// # Errors
/// [`MapError::NoPart`].
pub fn maps_of(dataset: &Dataset, part: Part) -> Result<&[u32]> {
    let split = &dataset.manifest().split;
    let has_maps = |&part: &Part| !split.maps(part).is_empty();
    match has_maps(&part) {
        true => Ok(split.maps(part)),
        false => {
            let others = Part::ALL.into_iter().filter(has_maps).collect();
            Err(MapError::NoPart { part, others }).at_file(Place::Dataset, dataset.root())
        }
    }
}

/// The form in which labels are compared.
#[derive(Debug, Clone, Copy)]
pub enum Target {
    /// Power relative to the link's maximum, in \[0, 1\].
    Linear,
    /// A protocol's learning target.
    Normalised(Normalization),
}

impl Target {
    /// The target of a data set's labels in a domain.
    ///
    /// # Errors
    /// For the normalised domain, those of [`learning_target`].
    pub fn of(dataset: &Dataset, domain: Domain) -> Result<Self> {
        match domain {
            Domain::Linear => Ok(Self::Linear),
            Domain::Normalised => Ok(learning_target(dataset)?.2),
        }
    }

    /// The target of a data set's labels as its manifest holds it, without reading them: statistics that it holds of each map make
    /// those of the training maps to the last digits. `None` where it holds none, as of imported labels.
    pub(crate) fn stored(dataset: &Dataset, domain: Domain) -> Option<Self> {
        if let Domain::Linear = domain {
            return Some(Self::Linear);
        }
        let manifest = dataset.manifest();
        let train = manifest.split.maps(Part::Train);
        let maps = || manifest.maps.iter().filter(|map| train.contains(&map.id));
        let is_silent =
            |map: &MapEntry| map.valid() > 0 && map.statistics["relative_power"].is_null();
        if maps().any(is_silent) {
            return None;
        }
        let protocol = protocol_of(dataset).unwrap_or_default();
        let normalization = |train| Normalization::of(protocol, train);
        let train = pooled(maps()).filter(|train| train.std > 0.0);
        train.map(normalization).map(Self::Normalised)
    }

    /// Makes the stored label of a link into the target, in double precision from the stored values on: `row` has a value
    /// for each bin.
    ///
    /// # Errors
    /// A value that is not finite, and statistics that cannot be divided by.
    ///
    /// # Panics
    /// When there is no such link.
    pub fn write(
        &self,
        samples: &Samples,
        link: usize,
        row: &mut [f64],
    ) -> Result<(), NormalizationError> {
        let bins = row.len();
        samples.read(link * bins..(link + 1) * bins, row);
        match self {
            Target::Linear => relative_power(row).map(|_| ()),
            Target::Normalised(normalization) => normalization.apply(row),
        }
    }
}

/// Hands over the targets of the labelled links of some maps, in ascending order of map and row, at most `links` rows at a
/// time, with their map. Returns the number of links.
///
/// # Panics
/// When the data set stores no angle power spectra.
pub fn for_each_block(
    dataset: &Dataset,
    part: Part,
    target: Target,
    links: usize,
    mut take: impl FnMut(&[f64], u32) -> Result<()>,
) -> Result<usize> {
    let (mut rows, mut handed_over) = (Vec::new(), 0);
    for map in dataset.maps_of(part) {
        let map = map?;
        let aps = spectra(&map);
        let valid: Vec<usize> = map.valid_links().collect();
        for some in valid.chunks(links) {
            rows.resize(some.len() * aps.bins(), 0.0);
            rows.par_chunks_mut(aps.bins())
                .zip(some)
                .try_for_each(|(row, &link)| target.write(aps.samples(), link, row))
                .at(Place::Map(map.id))?;
            take(&rows, map.id)?;
        }
        handed_over += valid.len();
    }
    Ok(handed_over)
}

/// Mean and deviation of linear relative power over all labels of the training maps, which are read once for it. The
/// same bits for any number of threads: [`Moments`] are exact sums.
///
/// # Panics
/// When the data set stores no angle power spectra.
pub fn training_statistics(dataset: &Dataset) -> Result<MeanStd> {
    let mut total = Moments::default();
    for map in dataset.maps_of(Part::Train) {
        let map = map?;
        let aps = spectra(&map);
        let links: Vec<usize> = map.valid_links().collect();
        let of_link = |row: &mut Vec<f64>, &link: &usize| -> Result<Moments> {
            Target::Linear.write(aps.samples(), link, row)?;
            let mut moments = Moments::default();
            moments.add(row)?;
            Ok(moments)
        };
        let of_map = links
            .par_iter()
            .map_init(|| vec![0.0; aps.bins()], of_link)
            .try_reduce(Moments::default, |mut a, b| {
                a.merge(&b);
                Ok(a)
            });
        total.merge(&of_map.at(Place::Map(map.id))?);
    }
    let statistics = total.mean_std().ok_or(ScoreError::NoTrainingLabel)?;
    match statistics.std > 0.0 {
        true => Ok(statistics),
        false => Err(ScoreError::FlatLabels).at_file(Place::Dataset, dataset.root()),
    }
}

/// The spectra of a map.
///
/// # Panics
/// When the data set stores none.
pub fn spectra(map: &MapData) -> &Profile {
    map.aps.as_ref().expect("the layout stores them")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic;

    #[test]
    fn labels_of_one_element_are_refused_since_they_are_flat() {
        let mut plan = synthetic::plan(3, 2, 20);
        plan.label.array = aps_label::Array::UniformLinear {
            elements: 1,
            spacing_wavelengths: 0.5,
        };
        let folder = tempfile::tempdir().unwrap();
        let dataset = synthetic::made(&plan, folder.path(), &[0, 1, 2]);
        let told = learning_target(&dataset).unwrap_err().chain();
        assert!(told.contains("flat"), "{told}");
        assert!(Target::stored(&dataset, Domain::Normalised).is_none());
        Target::of(&dataset, Domain::Linear).unwrap();
    }
}
