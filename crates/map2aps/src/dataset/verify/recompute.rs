//! Links computed anew, to be compared with those stored.

use aps_data::{Dataset, MapData, MapEntry, PathTable, Profile};
use aps_label::Labeler;
use aps_raytrace::glam::DVec2;
use aps_raytrace::{Scene, TraceConfig, Tracer};
use rayon::prelude::*;

use super::findings::Findings;
use crate::dataset::{LinkMaker, Rows, stored_paths, stored_pdp};
use crate::error::Result;
use crate::sampling::{self, Receivers, Sampling};
use crate::settings;
use crate::tally::Tally;

/// Settings of a data set by which its links are computed anew.
pub struct Recomputation<'d> {
    dataset: &'d Dataset,
    trace: TraceConfig,
    sampling: Sampling,
    labeler: Labeler,
}

/// Arrays that are stored of a map.
struct Stored<'m> {
    map: &'m MapData,
    pdp: Option<Profile>,
    paths: Option<PathTable>,
}

impl<'d> Recomputation<'d> {
    /// `None` when the data set was not traced here.
    pub fn new(dataset: &'d Dataset) -> Result<Option<Self>> {
        let configuration = &dataset.manifest().configuration;
        let Some((sampling, trace)) = settings::tracing_of(configuration)? else {
            return Ok(None);
        };
        let label = settings::label_of(configuration)?;
        Ok(Some(Self {
            dataset,
            trace,
            sampling,
            labeler: Labeler::new(&label)?,
        }))
    }

    /// Compares terminals and the given links of a map.
    pub fn check(
        &self,
        entry: &MapEntry,
        map: &MapData,
        given: &Scene,
        links: &[usize],
        findings: &mut Findings<'_>,
    ) -> Result<()> {
        let manifest = self.dataset.manifest();
        let tx = self.sampling.tx_per_map;
        let drawn = sampling::draw(given, manifest.seed, entry.id, tx, self.sampling.pool());
        let is_drawn = drawn.is_ok_and(|drawn| {
            let same = |drawn: &[DVec2], stored: &[[f64; 2]]| {
                let drawn = drawn.iter().map(DVec2::to_array);
                drawn.eq(stored.iter().copied())
            };
            same(&drawn.tx, &map.tx_m) && same(&drawn.rx, &map.rx_m)
        });
        if !is_drawn {
            findings.add(format!(
                "map {}: positions are not those that seed {} draws",
                entry.id, manifest.seed
            ));
        }
        if links.is_empty() {
            return Ok(());
        }
        let tracer = Tracer::new(given, self.trace.clone())?;
        let stored = Stored {
            map,
            pdp: stored_pdp(self.dataset, entry.id)?,
            paths: stored_paths(self.dataset, entry.id)?,
        };
        let differences: Vec<Option<String>> = links
            .par_iter()
            .map(|&link| {
                let [tx, rx] = map.links[link];
                let skipped = self.skips_a_reached_point(&tracer, map, link);
                if !matches!(skipped, Ok(false)) {
                    let (id, point) = (entry.id, rx - 1);
                    return Ok(Some(match skipped {
                        Ok(_) => format!(
                            "map {id}: tx {tx} reaches point {point}, which is not among its receivers"
                        ),
                        Err(error) => format!(
                            "map {id}: tx {tx} passes over point {point}, which cannot be traced: {}",
                            error.chain()
                        ),
                    }));
                }
                let what = match self.link(&tracer, map, link) {
                    Ok(rows) => self.difference(&stored, link, &rows)?,
                    Err(error) => Some(format!("{}; it is", error.chain())),
                };
                Ok(what.map(|what| {
                    format!(
                        "map {}, link {link} (tx {tx}, rx {rx}): {what} not what its map gives",
                        entry.id
                    )
                }))
            })
            .collect::<Result<_>>()?;
        for difference in differences.into_iter().flatten() {
            findings.add(difference);
        }
        Ok(())
    }

    /// Tells if the point before a link's receiver was passed over although the transmitter reaches it.
    fn skips_a_reached_point(
        &self,
        tracer: &Tracer<'_>,
        map: &MapData,
        link: usize,
    ) -> Result<bool> {
        let [tx, rx] = map.links[link];
        let before = rx.checked_sub(1).map(|point| [tx, point]);
        let Some([_, point]) = before.filter(|_| self.sampling.receivers == Receivers::Reached)
        else {
            return Ok(false);
        };
        if link > 0 && Some(map.links[link - 1]) == before {
            return Ok(false);
        }
        let tx = tracer.transmitter(DVec2::from(map.tx_m[tx as usize]))?;
        let rx = tracer.receiver(DVec2::from(map.rx_m[point as usize]))?;
        LinkMaker::new(false).trace(tracer, &tx, &rx, &mut Tally::default())
    }

    /// A link as it is made.
    fn link(&self, tracer: &Tracer<'_>, map: &MapData, link: usize) -> Result<Rows> {
        let mut rows = Rows::default();
        let (tx, rx) = map.ends_m(link);
        let tx = tracer.transmitter(DVec2::from(tx))?;
        let rx = tracer.receiver(DVec2::from(rx))?;
        let mut maker = LinkMaker::new(true);
        maker.trace(tracer, &tx, &rx, &mut rows.tally)?;
        maker.label(&self.labeler, map.links[link], &mut rows)?;
        maker.push_paths(&mut rows);
        Ok(rows)
    }

    /// The first of a link's arrays that differ, in words.
    fn difference(&self, stored: &Stored<'_>, link: usize, rows: &Rows) -> Result<Option<String>> {
        let layout = &self.dataset.manifest().layout;
        let (status, found) = (stored.map.status[link], rows.status[0]);
        if status != found {
            return Ok(Some(format!(
                "status {status}, which should be {found}, is"
            )));
        }
        if stored.map.fallback[link] != rows.fallback[0] {
            return Ok(Some("fallback is".into()));
        }
        let profiles = [
            ("aps", layout.aps, &rows.aps, stored.map.aps.as_ref()),
            ("pdp", layout.pdp, &rows.pdp, stored.pdp.as_ref()),
        ];
        for (name, layout, made, stored) in profiles {
            if let (Some(layout), Some(stored)) = (layout, stored) {
                let made = Profile::encode(&made.rows(), &layout, &rows.status)?;
                if !made.is_same_row(0, stored, link) {
                    return Ok(Some(format!("{name} is")));
                }
            }
        }
        let paths = stored.paths.as_ref().map(|table| table.of_links([link]));
        let differ = paths.is_some_and(|paths| !paths.is_same(&rows.paths));
        Ok(differ.then(|| "paths are".into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic;
    use aps_raytrace::scene::Location;

    #[test]
    fn a_point_in_a_building_that_was_passed_over_is_a_finding() {
        let root = tempfile::tempdir().unwrap();
        let plan = synthetic::plan(1, 1, 4);
        let dataset = synthetic::made(&plan, root.path(), &[0]);
        let (entry, mut map) = (&dataset.manifest().maps[0], dataset.map(0).unwrap());
        let scene = plan.maps.load(0, plan.seed, plan.scene).unwrap();
        let mut diagonal = (0..256).map(|i| DVec2::splat(f64::from(i)));
        let indoors = diagonal.find(|&p| matches!(scene.locate(p), Location::Inside { .. }));
        let link = map.links.iter().position(|&[_, rx]| rx > 0).unwrap();
        map.rx_m[map.links[link][1] as usize - 1] = indoors.unwrap().to_array();
        // The link before it, if any, was to that point.
        map.links.drain(..link);
        let mut told = Vec::new();
        let mut found = |finding| told.push(finding);
        let mut findings = Findings {
            found: &mut found,
            count: 0,
        };
        let recomputation = Recomputation::new(&dataset).unwrap().unwrap();
        recomputation
            .check(entry, &map, &scene, &[0], &mut findings)
            .unwrap();
        assert_eq!(findings.count, 2);
        assert!(told[1].contains("which cannot be traced"), "{told:?}");
    }
}
