//! Labelled links as models learn from them: condition images and targets.

use std::sync::OnceLock;

use aps_data::{ConditionConfig, ConditionImages, Dataset, MapData, Part, Samples};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

use crate::error::{At, Place, Result};
use crate::maps::identity::Kept;
use crate::maps::{MapError, MapSource, ascending};
use crate::polar::PolarViews;
use crate::scenes::Scenes;
use crate::scores::{Domain, ScoreError};
use crate::targets::{self, Target};

/// A labelled link of a data set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Example {
    /// Id of its map.
    pub map: u32,
    /// Row of the link in the map.
    pub link: usize,
    /// Row of its transmitter in the map.
    pub tx: u32,
    /// Row of its receiver in the map.
    pub rx: u32,
    /// Place of the transmitter \[m\].
    pub tx_m: [f64; 2],
    /// Place of the receiver \[m\].
    pub rx_m: [f64; 2],
}

/// Number of links to draw, and the seed that draws them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Draw {
    /// Most links to keep.
    pub links: usize,
    /// Seed of the choice.
    pub seed: u64,
}

/// The labelled links of some maps, in the order in which predictions are scored: maps ascending, links in the order of their
/// rows. Labels are held as they are stored, in dB and in their precision, or stay on disk ([`Examples::open`]); they are made into
/// targets when they are asked for, in a few microseconds each.
///
/// Held: 416 bytes a link in half precision, 776 in single precision, as imported data have it: 0.96 and 1.8 GB for the paper's
/// 2.3 million.
#[derive(Debug, Clone)]
pub struct Examples {
    list: Vec<Example>,
    /// Maps of the examples, by ascending id.
    pub(crate) maps: Vec<ExampleMap>,
    labels: Labels,
    bins: usize,
    /// Settings of the condition images.
    images: ConditionConfig,
    /// Settings and seed of the data set's maps, as its manifest has them.
    origin: (Value, u64),
}

/// Labels of the examples.
#[derive(Debug, Clone)]
enum Labels {
    /// Held in memory, and the form in which they are learnt.
    Held(Samples, Target),
    /// Labels left on disk.
    Stored {
        dataset: Box<Dataset>,
        domain: Domain,
        /// Form in which they are learnt, found when it is first asked for.
        target: OnceLock<Target>,
    },
}

/// The buildings of a map, and its image painter from the first image on.
#[derive(Debug, Clone)]
pub(crate) struct ExampleMap {
    pub id: u32,
    pub buildings: Kept,
    images: OnceLock<ConditionImages>,
}

impl Examples {
    /// Loads the examples of a part, with targets as [`Scoring`](crate::Scoring) compares them: for normalised ones, the
    /// training maps are read once more.
    ///
    /// # Errors
    /// A data set that stores no angle power spectra, cannot be read, or has nothing to normalise by.
    pub fn load(dataset: &Dataset, part: Part, domain: Domain) -> Result<Self> {
        let target = Target::of(dataset, domain)?;
        Self::of_maps(dataset, dataset.manifest().split.maps(part), target, None)
    }

    /// Loads the examples of some maps, or some of them, drawn.
    ///
    /// # Errors
    /// A data set that stores no angle power spectra, cannot be read, or holds other numbers of labels than its manifest says.
    pub fn of_maps(
        dataset: &Dataset,
        maps: &[u32],
        target: Target,
        draw: Option<Draw>,
    ) -> Result<Self> {
        let aps = dataset.aps_layout()?;
        dataset.check_sizes(maps)?;
        let total = targets::labelled_links(dataset, maps);
        let count = draw.map_or(total, |draw| draw.links.min(total));
        let db = Samples::with_capacity(aps.dtype, count * aps.axis.count);
        Self::with_labels(dataset, maps, Labels::Held(db, target), draw)
    }

    /// Opens the examples of a part, as [`Examples::load`] loads them, but leaves labels on disk: each is read when its target is
    /// asked for. Statistics to normalise by are those that the manifest holds of the training maps, to the last digits; where it
    /// holds none, as of imported labels, these maps are read when the first normalised target is asked for.
    ///
    /// # Errors
    /// A data set that stores no angle power spectra, or cannot be read.
    pub fn open(dataset: &Dataset, part: Part, domain: Domain) -> Result<Self> {
        dataset.check_sizes(dataset.manifest().split.maps(part))?;
        let labels = Labels::Stored {
            dataset: Box::new(dataset.clone()),
            domain,
            target: Target::stored(dataset, domain).map_or_else(OnceLock::new, OnceLock::from),
        };
        Self::with_labels(dataset, dataset.manifest().split.maps(part), labels, None)
    }

    fn with_labels(
        dataset: &Dataset,
        maps: &[u32],
        labels: Labels,
        draw: Option<Draw>,
    ) -> Result<Self> {
        let aps = dataset.aps_layout()?;
        let maps = ascending(maps.iter().copied());
        let total = targets::labelled_links(dataset, &maps);
        let drawn = draw.filter(|draw| draw.links < total).map(|draw| {
            let mut generator = ChaCha8Rng::seed_from_u64(draw.seed);
            let mut all: Vec<usize> = (0..total).collect();
            let mut drawn = all.partial_shuffle(&mut generator, draw.links).0.to_vec();
            drawn.sort_unstable();
            drawn
        });
        let count = drawn.as_ref().map_or(total, Vec::len);
        let mut examples = Self {
            list: Vec::with_capacity(count),
            maps: Vec::with_capacity(maps.len()),
            labels,
            bins: aps.axis.count,
            images: ConditionConfig::default(),
            origin: {
                let manifest = dataset.manifest();
                (manifest.configuration.clone(), manifest.seed)
            },
        };
        let (mut passed, mut wanted) = (0, drawn.iter().flatten().copied().peekable());
        for id in maps {
            let map = match examples.labels {
                Labels::Held(..) => dataset.map(id)?,
                Labels::Stored { .. } => dataset.links(id)?,
            };
            for link in map.valid_links() {
                if drawn.is_none() || wanted.next_if_eq(&passed).is_some() {
                    examples.push(&map, link);
                }
                passed += 1;
            }
            examples.maps.push(ExampleMap {
                id,
                buildings: Kept::new(dataset, id, map.buildings),
                images: OnceLock::new(),
            });
        }
        if passed != total {
            let folder = dataset.root().display().to_string();
            return Err(ScoreError::Damaged {
                folder,
                samples: total,
            }
            .into());
        }
        Ok(examples)
    }

    fn push(&mut self, map: &MapData, link: usize) {
        let ([tx, rx], (tx_m, rx_m)) = (map.links[link], map.ends_m(link));
        if let Labels::Held(db, _) = &mut self.labels {
            let bins = link * self.bins..(link + 1) * self.bins;
            db.append(targets::spectra(map).samples(), bins);
        }
        self.list.push(Example {
            map: map.id,
            link,
            tx,
            rx,
            tx_m,
            rx_m,
        });
    }

    /// Sets the rows and columns of condition images, which show the whole map.
    pub fn with_image_size(mut self, size: usize) -> Self {
        self.images.image_size = Some(size);
        for map in &mut self.maps {
            map.images = OnceLock::new();
        }
        self
    }

    /// The links.
    pub fn list(&self) -> &[Example] {
        &self.list
    }

    /// Length of a target.
    pub fn bins(&self) -> usize {
        self.bins
    }

    /// Rows and columns of a condition image: those of the map's image, or what [`Examples::with_image_size`] made them.
    pub fn image_shape(&self) -> [usize; 2] {
        let grid = self.maps.first().map(|map| map.buildings.image.grid());
        let own = grid.map_or([0; 2], |grid| [grid.height, grid.width]);
        self.images.image_size.map_or(own, |size| [size.max(1); 2])
    }

    /// Length of a condition image: 3 planes.
    pub fn image_len(&self) -> usize {
        3 * self.image_shape().iter().product::<usize>()
    }

    /// The geometry of all maps, which a data set does not keep: those that it was made from must be given, unless they are
    /// synthetic. Links name their maps by [`Examples::map_index`].
    ///
    /// # Errors
    /// [`MapError::NoScene`], [`MapError::NoImage`] and [`MapError::OtherBuildings`]; maps that cannot be read.
    pub(crate) fn polar_views(&self, maps: Option<&MapSource>) -> Result<PolarViews> {
        let (configuration, seed) = &self.origin;
        let scenes = Scenes::new(configuration, *seed, maps.cloned())?;
        let scene = |map: &ExampleMap| {
            let found = scenes.scene(map.id, &map.buildings)?;
            let missing = || match map.buildings.is_blank() {
                true => MapError::NoImage(map.id),
                false => MapError::NoScene(map.id),
            };
            Ok((map.id, found.ok_or_else(missing)?))
        };
        PolarViews::new(self.maps.iter().map(scene))
    }

    /// Place of an example's map among those of the examples.
    pub(crate) fn map_index(&self, example: usize) -> usize {
        let map = self.list[example].map;
        let place = self.maps.binary_search_by_key(&map, |map| map.id);
        place.expect("the map was loaded")
    }

    /// The form in which the labels are learnt.
    ///
    /// # Errors
    /// Errors of [`Target::of`], where labels stay on disk.
    pub(crate) fn form(&self) -> Result<Target> {
        match &self.labels {
            Labels::Held(_, target) => Ok(*target),
            Labels::Stored {
                dataset,
                domain,
                target,
            } => match target.get() {
                Some(target) => Ok(*target),
                // Whoever else asks meanwhile finds it too: threads that waited here could not help to.
                None => Target::of(dataset, *domain).map(|found| *target.get_or_init(|| found)),
            },
        }
    }

    /// Writes the target of an example into a row of [`Examples::bins`] values.
    ///
    /// # Errors
    /// A label that cannot be normalised, or read where it stays on disk.
    ///
    /// # Panics
    /// When there is no such example, or `row` has another length.
    pub fn write_target(&self, example: usize, row: &mut [f64]) -> Result<()> {
        assert_eq!(row.len(), self.bins, "a value for each bin");
        let Example { map, link, .. } = self.list[example];
        let written = match &self.labels {
            Labels::Held(db, target) => target.write(db, example, row),
            Labels::Stored { dataset, .. } => {
                let label = dataset.spectrum(map, link)?;
                self.form()?.write(&label, 0, row)
            }
        };
        written.at(Place::Link(link))
    }

    /// The targets of all examples; shape (examples, bins).
    ///
    /// # Errors
    /// A label that cannot be normalised.
    pub fn targets(&self) -> Result<Vec<f32>> {
        let mut targets = Vec::with_capacity(self.list.len() * self.bins);
        let mut row = vec![0.0; self.bins];
        for example in 0..self.list.len() {
            self.write_target(example, &mut row)?;
            targets.extend(row.iter().map(|&value| value as f32));
        }
        Ok(targets)
    }

    /// Writes the condition image of an example, of [`Examples::image_len`] values: buildings, transmitter, receiver.
    ///
    /// # Panics
    /// When there is no such example, or `image` has another length.
    pub fn write_condition(&self, example: usize, image: &mut [f32]) {
        let Example { tx_m, rx_m, .. } = self.list[example];
        let map = &self.maps[self.map_index(example)];
        let paint = || ConditionImages::new(&map.buildings.image, self.images);
        map.images.get_or_init(paint).write(tx_m, rx_m, image);
    }
}
