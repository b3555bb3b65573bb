//! A quantity over a whole map, cell by cell, the coarse picture first.
//!
//! The answer is a line of JSON for each block of cells: the first tells the grid, the last cells come with the lowest stride. A
//! cell that can hold no receiver has null for every value.

use std::collections::VecDeque;

use aps_label::{Label, LabelConfig, Labeler, PathSample, Scratch, Status};
use aps_metrics::LevelDistance;
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::Area;
use aps_raytrace::{Link, TerminalError, TraceError};
use map2aps::aps_data::sample_of;
use rayon::prelude::*;
use serde::Serialize;

use crate::cache::{Cache, TxSide};
use crate::fault::Fault;
use crate::request::{CoverageQuestion, Show};
use crate::request_handle::RequestHandle;

/// Most cells along a side.
const MAX_SIDE: f64 = 256.0;

/// Cells between those of each pass.
const STRIDES: [u32; 5] = [16, 8, 4, 2, 1];

/// Cells of a line.
const BLOCK: usize = 256;

/// Place of the receiver in its cell, in sides: walls stand on whole metres, as middles would.
const MIDDLE: f64 = 0.45;

/// Cells of a map.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Grid {
    min: [f64; 2],
    cell_m: f64,
    middle: f64,
    columns: u32,
    rows: u32,
    of: u32,
}

impl Grid {
    fn new(area: Area, cell_m: f64) -> Result<Self, Fault> {
        let size = area.max - area.min;
        let side = size.max_element();
        Fault::range("cell_m", cell_m, side / MAX_SIDE..=side)?;
        let [x, y] = (size / cell_m).ceil().to_array().map(|n| n as u32);
        Ok(Self {
            min: area.min.to_array(),
            cell_m,
            middle: MIDDLE,
            columns: x,
            rows: y,
            of: x * y,
        })
    }

    fn place(&self, cell: u32) -> DVec2 {
        let (i, j) = (cell % self.columns, cell / self.columns);
        let steps = DVec2::new(f64::from(i), f64::from(j)) + MIDDLE;
        DVec2::from(self.min) + self.cell_m * steps
    }

    /// The cells of a pass: those of its stride that no pass before had.
    fn pass(&self, pass: usize) -> Vec<u32> {
        let is_on = |cell: u32, stride: u32| {
            (cell % self.columns).is_multiple_of(stride)
                && (cell / self.columns).is_multiple_of(stride)
        };
        let before = pass.checked_sub(1).map(|before| STRIDES[before]);
        let is_new = |&cell: &u32| {
            is_on(cell, STRIDES[pass]) && !before.is_some_and(|stride| is_on(cell, stride))
        };
        (0..self.of).filter(is_new).collect()
    }
}

/// Shared state of a coverage computation.
pub struct Survey {
    /// The cells.
    pub grid: Grid,
    show: Show,
    heading_deg: f64,
    labeler: Labeler,
    /// The chosen limits, and for an error the reference ones.
    sides: Vec<TxSide>,
    cache: Cache,
    handle: RequestHandle,
    /// Cells of the lines to come, each with its stride.
    ahead: VecDeque<(u32, Vec<u32>)>,
    /// Cells of the lines before; none before the line of the grid.
    done: Option<u32>,
}

/// The values of some cells, those first that come first.
#[derive(Debug, Default, Serialize)]
struct Block {
    stride: u32,
    done: u32,
    at: Vec<u32>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    level_db: Vec<Option<f64>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    paths: Vec<Option<usize>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    sight: Vec<Option<u8>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    direction_deg: Vec<Option<f64>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    error_db: Vec<Option<f64>>,
}

/// Values of a cell: none for one that can hold no receiver, and for what is not shown.
#[derive(Default)]
struct Values {
    level_db: Option<f64>,
    paths: Option<usize>,
    sight: Option<bool>,
    direction_deg: Option<f64>,
    /// Error of the spectrum \[dB\]; none also where there is no path, even within the reference limits.
    error_db: Option<f64>,
}

impl Block {
    /// Appends a cell.
    fn push(&mut self, cell: u32, show: Show, values: Values) {
        self.at.push(cell);
        match show {
            Show::Link => {
                self.level_db.push(values.level_db.map(tenths));
                self.paths.push(values.paths);
                self.sight.push(values.sight.map(u8::from));
                self.direction_deg.push(values.direction_deg.map(tenths));
            }
            Show::Error => self.error_db.push(values.error_db.map(tenths)),
        }
    }
}

/// Buffers of a thread.
#[derive(Default)]
struct Buffers {
    link: Link,
    samples: Vec<PathSample>,
    scratch: Scratch,
    labels: [Label; 2],
}

impl Survey {
    /// Prepares map and transmitter.
    ///
    /// # Errors
    /// As for a link.
    pub fn new(
        cache: &Cache,
        question: &CoverageQuestion,
        handle: RequestHandle,
    ) -> Result<Self, Fault> {
        let label = LabelConfig {
            pdp: false,
            ..question.label.config()?
        };
        let city = cache.city(&question.city)?;
        let mut configs = vec![question.trace.config()?];
        if question.show == Show::Error {
            configs.push(question.trace.reference()?);
        }
        let mut sides = Vec::new();
        for config in &configs {
            handle.check()?;
            sides.push(cache.tx_side(&city, config, question.tx, &handle)?);
        }
        let grid = Grid::new(city.area, question.cell_m)?;
        let mut ahead = VecDeque::new();
        for (pass, &stride) in STRIDES.iter().enumerate() {
            let cells = grid.pass(pass);
            ahead.extend(cells.chunks(BLOCK).map(|cells| (stride, cells.to_vec())));
        }
        Ok(Self {
            grid,
            show: question.show,
            heading_deg: question.label.heading_deg,
            labeler: Labeler::new(&label).map_err(Fault::of)?,
            sides,
            cache: cache.clone(),
            handle,
            ahead,
            done: None,
        })
    }

    fn block(&self, cells: &[u32]) -> Result<Block, Fault> {
        let one = |buffers: &mut Buffers, &cell: &u32| {
            self.handle.check()?;
            self.values(self.grid.place(cell), buffers)
        };
        let all = || -> Result<Vec<_>, Fault> {
            let cells = cells.par_iter();
            cells.map_init(Buffers::default, one).collect()
        };
        let values = self.cache.on_all_threads(all)?;
        let mut block = Block::default();
        for (&cell, values) in cells.iter().zip(values) {
            block.push(cell, self.show, values);
        }
        Ok(block)
    }

    /// The values at a place.
    fn values(&self, place: DVec2, buffers: &mut Buffers) -> Result<Values, Fault> {
        for (i, TxSide { tracer, tx }) in self.sides.iter().enumerate() {
            use TerminalError::{InsideBuilding, OnWall, OutsideArea};
            let rx = match tracer.value.receiver(place) {
                Ok(rx) => rx,
                // Half of a last cell can lie beyond the border.
                Err(OutsideArea { .. } | InsideBuilding { .. } | OnWall { .. }) => {
                    return Ok(Values::default());
                }
                Err(error) => return Err(Fault::of(TraceError::Receiver(error))),
            };
            if tx.value.position() == place {
                return Ok(Values::default());
            }
            let joined = tracer.value.link(&tx.value, &rx, &mut buffers.link);
            joined.map_err(Fault::of)?;
            let paths = &buffers.link.paths;
            if self.show == Show::Link {
                let total: f64 = paths.iter().map(|p| p.power()).sum();
                let strongest = paths.iter().max_by(|p, q| p.power().total_cmp(&q.power()));
                return Ok(Values {
                    level_db: (total > 0.0).then(|| 10.0 * total.log10()),
                    paths: Some(paths.len()),
                    sight: Some(paths.iter().any(|p| p.is_line_of_sight())),
                    direction_deg: strongest.map(|p| p.arrival_azimuth_rad.to_degrees()),
                    error_db: None,
                });
            }
            let samples = &mut buffers.samples;
            let heading_rad = self.heading_deg.to_radians();
            let seen = |path| sample_of(path).from_heading(heading_rad);
            samples.clear();
            samples.extend(paths.iter().map(seen));
            let label = &mut buffers.labels[i];
            let status = self
                .labeler
                .label_into(samples, &mut buffers.scratch, label);
            if status.map_err(Fault::of)? == Status::NoPath {
                label.aps_db.clear();
            }
        }
        let [found, truth] = &buffers.labels;
        let found = (!found.aps_db.is_empty()).then_some(found.aps_db.as_slice());
        let error = LevelDistance::of(&truth.aps_db, found);
        Ok(Values {
            error_db: (!truth.aps_db.is_empty()).then_some(error.mean_db),
            ..Values::default()
        })
    }
}

/// The lines of the answer: the grid, all cells, and a fault that ends them.
impl Iterator for Survey {
    type Item = Vec<u8>;

    fn next(&mut self) -> Option<Vec<u8>> {
        let Some(done) = self.done else {
            self.done = Some(0);
            return Some(line(&self.grid));
        };
        let (stride, cells) = self.ahead.pop_front()?;
        let done = done + cells.len() as u32;
        self.done = Some(done);
        Some(match self.block(&cells) {
            Ok(block) => line(&Block {
                stride,
                done,
                ..block
            }),
            Err(fault) => {
                self.ahead.clear();
                line(&fault.reply())
            }
        })
    }
}

fn tenths(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}

fn line(value: &impl Serialize) -> Vec<u8> {
    let mut line = serde_json::to_vec(value).unwrap_or_default();
    line.push(b'\n');
    line
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::cache::tests::cache;
    use crate::request::read;
    use crate::request::tests::question;
    use crate::request_handle::LatestRequests;

    #[test]
    fn passes_have_every_cell_once() {
        let area = Area {
            min: DVec2::new(-3.0, 5.0),
            max: DVec2::new(97.0, 38.0),
        };
        let grid = Grid::new(area, 2.0).unwrap();
        assert_eq!((grid.columns, grid.rows), (50, 17));
        let mut cells: Vec<u32> = (0..STRIDES.len()).flat_map(|i| grid.pass(i)).collect();
        cells.sort_unstable();
        assert!(cells.into_iter().eq(0..50 * 17));
        assert!(grid.place(51).distance(DVec2::new(-0.1, 7.9)) < 1e-12);
    }

    /// A survey of a synthetic city.
    pub fn survey(cache: &Cache, handle: RequestHandle) -> Survey {
        let mut asked = question();
        let fields = asked.as_object_mut().unwrap();
        fields.remove("rx");
        fields.insert("show".into(), "link".into());
        fields.insert("cell_m".into(), 4.0.into());
        let asked = read(asked.to_string().as_bytes()).unwrap();
        Survey::new(cache, &asked, handle).unwrap()
    }

    #[test]
    fn survey_ends_when_a_newer_one_is_asked_for() {
        let latest = LatestRequests::default();
        let mut survey = survey(&cache(), latest.register(1, "coverage"));
        let mut next = || Some(String::from_utf8(survey.next()?).unwrap());
        let [_, second] = [(); 2].map(|()| next().unwrap());
        latest.register(1, "coverage");
        let last = next().unwrap();
        assert!(next().is_none());
        assert!(second.contains("level_db") && last.contains("overtaken"));
    }

    #[test]
    fn cells_without_end_are_refused() {
        for cell_m in [0.0, -1.0, 0.9, f64::NAN, 1e9] {
            assert!(Grid::new(Area::RADIOMAPSEER, cell_m).is_err(), "{cell_m}");
        }
        assert!(Grid::new(Area::RADIOMAPSEER, 1.0).is_ok());
    }
}
