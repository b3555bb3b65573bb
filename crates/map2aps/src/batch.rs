//! Many links traced and labelled at once, in memory.

use std::collections::{BTreeMap, HashMap};

use aps_data::{FILL_DB, PathTable};
use aps_label::{Label, Labeler, PathError, PathSample, Scratch, Status};
use aps_raytrace::glam::DVec2;
use aps_raytrace::{Link, PathRecord, Receiver, TerminalError, Tracer, Transmitter};
use rayon::prelude::*;

use crate::control::{Control, Work};
use crate::error::{At, Place, Result};

/// Most transmitters whose links a thread makes side by side. A receiver's tables, up to a megabyte with two diffractions, are read from
/// memory once for all of them.
pub(crate) const SIDE_BY_SIDE: usize = 4;

/// Transmitters that are prepared at a time: each takes up to some megabytes.
const TX_AT_ONCE: usize = 16;

/// Receivers that are prepared at a time: each takes some ten kilobytes.
const RX_AT_ONCE: usize = 4096;

/// Most links that a thread takes at a time.
const LINKS_AT_ONCE: usize = 64;

/// Receivers of a portion of links from each transmitter to each receiver; its transmitters take turns at them.
const RX_OF_A_PORTION: usize = LINKS_AT_ONCE / SIDE_BY_SIDE;

/// Traces the links from each transmitter to each receiver; each terminal is prepared once for every 16 transmitters and 4096
/// receivers. Link `t * rx.len() + r` goes from `tx[t]` to `rx[r]`. The same bits on any number of threads.
///
/// # Errors
/// A terminal that cannot stand where it is, two at one point, limits of the tracer that are met, and cancellation.
pub fn trace_links(
    tracer: &Tracer<'_>,
    tx: &[DVec2],
    rx: &[DVec2],
    control: &Control<'_>,
) -> Result<PathTable> {
    begin(control, tx.len().saturating_mul(rx.len()));
    // By transmitter, the portions of its links.
    let mut of_tx: Vec<Vec<PathTable>> = vec![Vec::new(); tx.len()];
    for (block, rx) in rx.chunks(RX_AT_ONCE).enumerate() {
        let first_rx = block * RX_AT_ONCE;
        let rx = prepare(rx, control, |r, point| {
            let place = Place::Receiver((first_rx + r) as i64);
            tracer.receiver(point).at(place)
        })?;
        for (group, tx) in tx.chunks(TX_AT_ONCE).enumerate() {
            let first_tx = group * TX_AT_ONCE;
            let tx = prepare(tx, control, |t, point| {
                let place = Place::TransmitterRow(first_tx + t);
                tracer.transmitter(point).at(place)
            })?;
            let portions: Vec<(usize, usize)> = (0..tx.len())
                .step_by(SIDE_BY_SIDE)
                .flat_map(|t| (0..rx.len()).step_by(RX_OF_A_PORTION).map(move |r| (t, r)))
                .collect();
            let traced: Vec<(usize, Vec<PathTable>)> = portions
                .into_par_iter()
                .map_init(Link::default, |link, (t, r)| {
                    let tx = &tx[t..tx.len().min(t + SIDE_BY_SIDE)];
                    let rx = &rx[r..rx.len().min(r + RX_OF_A_PORTION)];
                    let tables = trace_some(tracer, tx, rx, first_rx + r, link, control)?;
                    Ok((first_tx + t, tables))
                })
                .collect::<Result<_>>()?;
            for (first, tables) in traced {
                for (of_tx, table) in of_tx[first..].iter_mut().zip(tables) {
                    of_tx.push(table);
                }
            }
        }
    }
    let mut all = PathTable::default();
    for table in of_tx.iter().flatten() {
        all.push_table(table);
    }
    Ok(all)
}

/// Prepares terminals on all threads, each by its row.
fn prepare<T: Send>(
    points: &[DVec2],
    control: &Control<'_>,
    one: impl Fn(usize, DVec2) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let prepare = |(row, &point): (usize, &DVec2)| {
        control.check()?;
        one(row, point)
    };
    points.par_iter().enumerate().map(prepare).collect()
}

/// Traces the links of a portion; returns the paths by transmitter.
fn trace_some(
    tracer: &Tracer<'_>,
    tx: &[Transmitter],
    rx: &[Receiver],
    first_rx: usize,
    link: &mut Link,
    control: &Control<'_>,
) -> Result<Vec<PathTable>> {
    let mut tables = vec![PathTable::default(); tx.len()];
    for (r, rx) in (first_rx..).zip(rx) {
        for (tx, table) in tx.iter().zip(&mut tables) {
            control.check()?;
            let traced = tracer.link(tx, rx, link);
            traced.at(Place::Receiver(r as i64))?;
            table.push_records(&link.paths);
        }
    }
    control.progress.advance((tx.len() * rx.len()) as u64);
    Ok(tables)
}

/// Traces the links of pairs of a transmitter and a receiver, and keeps those of the paths of a link that `kept` chooses; link i is that of
/// pair i. Each place is prepared once, and all stay in memory: some ten kilobytes a receiver, up to some megabytes a transmitter. The same
/// bits on any number of threads.
///
/// # Errors
/// As [`trace_links`], by link.
pub fn trace_pairs(
    tracer: &Tracer<'_>,
    pairs: &[[DVec2; 2]],
    kept: impl Fn(&[PathRecord]) -> &[PathRecord] + Sync,
    control: &Control<'_>,
) -> Result<PathTable> {
    begin(control, pairs.len());
    let tx = prepare_ends(pairs, 0, control, |at| tracer.transmitter(at))?;
    let rx = prepare_ends(pairs, 1, control, |at| tracer.receiver(at))?;
    let some = |link: &mut Link, (part, pairs): (usize, &[[DVec2; 2]])| {
        let mut table = PathTable::default();
        for (row, pair) in (part * LINKS_AT_ONCE..).zip(pairs) {
            control.check()?;
            let traced = tracer.link(&tx[&bits(pair[0])], &rx[&bits(pair[1])], link);
            traced.at(Place::Link(row))?;
            table.push_records(kept(&link.paths));
        }
        control.progress.advance(pairs.len() as u64);
        Ok(table)
    };
    let parts = pairs.par_chunks(LINKS_AT_ONCE).enumerate();
    let parts = parts.map_init(Link::default, some);
    let mut all = PathTable::default();
    for part in &parts.collect::<Result<Vec<_>>>()? {
        all.push_table(part);
    }
    Ok(all)
}

/// Prepares each place at an end of pairs once, on all threads.
fn prepare_ends<T: Send>(
    pairs: &[[DVec2; 2]],
    end: usize,
    control: &Control<'_>,
    one: impl Fn(DVec2) -> Result<T, TerminalError> + Sync,
) -> Result<HashMap<[u64; 2], T>> {
    let rows = pairs.iter().enumerate().rev();
    let first: BTreeMap<[u64; 2], usize> = rows.map(|(row, pair)| (bits(pair[end]), row)).collect();
    let prepare = |(place, row): ([u64; 2], usize)| {
        control.check()?;
        Ok((place, one(pairs[row][end]).at(Place::Link(row))?))
    };
    first.into_par_iter().map(prepare).collect()
}

fn bits(place: DVec2) -> [u64; 2] {
    place.to_array().map(f64::to_bits)
}

/// Labels of links, a row each. Rows of links without a label hold [`FILL_DB`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LinkLabels {
    /// True for a link with a label, false for one without a path that the protocol counts.
    pub is_labelled: Vec<bool>,
    /// Angle power spectra \[dB\]; shape (links, bins).
    pub aps_db: Vec<f64>,
    /// Power delay profiles \[dB\]; shape (links, delays); empty unless the labeler makes them.
    pub pdp_db: Vec<f64>,
}

/// Labels the links of a table. The same bits on any number of threads.
///
/// # Errors
/// Paths that cannot be labelled, by link, and cancellation.
pub fn label_links(
    labeler: &Labeler,
    paths: &PathTable,
    control: &Control<'_>,
) -> Result<LinkLabels> {
    begin(control, paths.links());
    let bins = labeler.angles_deg().len();
    let delays = match labeler.config().pdp {
        true => labeler.delays_s().len(),
        false => 0,
    };
    let links = paths.links();
    let mut labels = LinkLabels {
        is_labelled: vec![false; links],
        aps_db: vec![FILL_DB; links * bins],
        pdp_db: vec![FILL_DB; links * delays],
    };
    // Without profiles there are no portions of them to hand out, so each is empty.
    let mut pdp: Vec<&mut [f64]> = match delays {
        0 => (0..links).map(|_| Default::default()).collect(),
        delays => labels.pdp_db.chunks_exact_mut(delays).collect(),
    };
    let rows = labels.aps_db.par_chunks_exact_mut(bins).zip(&mut pdp);
    rows.zip(&mut labels.is_labelled)
        .enumerate()
        .with_min_len(LINKS_AT_ONCE)
        .try_for_each_init(Buffers::default, |buffers, (link, ((aps, pdp), is))| {
            control.check()?;
            let status = buffers.label_stored(labeler, paths, link);
            *is = status.at(Place::Link(link))? == Status::Labelled;
            if *is {
                aps.copy_from_slice(&buffers.label.aps_db);
                pdp.copy_from_slice(&buffers.label.pdp_db);
            }
            control.progress.advance(1);
            Result::<()>::Ok(())
        })?;
    Ok(labels)
}

/// Buffers for the labels of links, one after the other: one a thread.
#[derive(Default)]
pub(crate) struct Buffers {
    samples: Vec<PathSample>,
    scratch: Scratch,
    /// The label made last.
    pub label: Label,
}

impl Buffers {
    /// Labels a link with these paths.
    pub fn label(
        &mut self,
        labeler: &Labeler,
        paths: impl Iterator<Item = PathSample>,
    ) -> Result<Status, PathError> {
        self.samples.clear();
        self.samples.extend(paths);
        labeler.label_into(&self.samples, &mut self.scratch, &mut self.label)
    }

    /// Labels a link of a table.
    pub fn label_stored(
        &mut self,
        labeler: &Labeler,
        paths: &PathTable,
        link: usize,
    ) -> Result<Status, PathError> {
        let samples = paths.paths_of(link).map(|path| paths.sample(path));
        self.label(labeler, samples)
    }
}

fn begin(control: &Control<'_>, links: usize) {
    control.progress.begin(Work {
        units: links as u64,
        name: "links",
        finished_maps: 0,
        maps: 0,
    });
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use aps_label::LabelConfig;
    use aps_raytrace::{Scene, TraceConfig};

    use super::*;
    use crate::error::Error;

    fn street() -> (Tracer<'static>, Vec<DVec2>, Vec<DVec2>) {
        let scene = Scene::from_radiomapseer("[[[40, 40], [60, 40], [60, 60], [40, 60]]]").unwrap();
        let tracer = Tracer::owning(scene, TraceConfig::default()).unwrap();
        let tx = (0..20).map(|i| DVec2::new(3.0 + f64::from(i), 20.0));
        let rx = (0..300).map(|i| DVec2::new(70.0 + f64::from(i % 20), 30.0 + f64::from(i / 20)));
        (tracer, tx.collect(), rx.collect())
    }

    #[test]
    fn links_of_many_transmitters_are_those_traced_one_by_one() {
        let (tracer, tx, rx) = street();
        let table = trace_links(&tracer, &tx, &rx, &Control::default()).unwrap();
        let mut one_by_one = PathTable::default();
        for &t in &tx {
            for &r in &rx {
                one_by_one.push_records(&tracer.trace(t, r).unwrap().paths);
            }
        }
        assert!(table.is_same(&one_by_one));

        for pdp in [false, true] {
            let config = LabelConfig {
                pdp,
                ..LabelConfig::paper()
            };
            let labeler = Labeler::new(&config).unwrap();
            let labels = label_links(&labeler, &table, &Control::default()).unwrap();
            let samples: Vec<PathSample> = table.paths_of(77).map(|p| table.sample(p)).collect();
            let one = labeler.label(&samples).unwrap().unwrap();
            assert_eq!(labels.aps_db[77 * 180..78 * 180], one.aps_db);
            let delays = one.pdp_db.len();
            assert_eq!(labels.pdp_db[77 * delays..78 * delays], one.pdp_db);
        }
    }

    #[test]
    fn pairs_in_any_order_are_the_links_traced_one_by_one() {
        let (tracer, tx, rx) = street();
        let pair = |i: usize| [tx[i * 7 % 3], rx[i * 31 % 40]];
        let pairs: Vec<[DVec2; 2]> = (0..150).map(pair).collect();
        let control = Control::default();
        let all = trace_pairs(&tracer, &pairs, |paths| paths, &control).unwrap();
        let first = trace_pairs(&tracer, &pairs, |paths| &paths[..1], &control).unwrap();
        let (mut all_alone, mut first_alone) = (PathTable::default(), PathTable::default());
        for [tx, rx] in &pairs {
            let paths = tracer.trace(*tx, *rx).unwrap().paths;
            all_alone.push_records(&paths);
            first_alone.push_records(&paths[..1]);
        }
        assert!(all.is_same(&all_alone) && first.is_same(&first_alone));
        assert!(all.delay_s.len() > first.delay_s.len());

        let mut inside = pairs;
        inside[9][1] = DVec2::splat(50.0);
        let error = trace_pairs(&tracer, &inside, |paths| paths, &control).unwrap_err();
        assert!(error.chain().starts_with("link 9: terminal at"), "{error}");
    }

    #[test]
    fn more_receivers_than_are_prepared_at_once_keep_their_order() {
        let (tracer, tx, rx) = street();
        let rx: Vec<DVec2> = rx.iter().copied().cycle().take(RX_AT_ONCE + 10).collect();
        let table = trace_links(&tracer, &tx[..2], &rx, &Control::default()).unwrap();
        let last = tracer.trace(tx[1], rx[RX_AT_ONCE + 9]).unwrap();
        let mut alone = PathTable::default();
        alone.push_records(&last.paths);
        assert!(table.of_links([table.links() - 1]).is_same(&alone));
    }

    #[test]
    fn bad_terminals_are_named_and_a_cancelled_trace_ends() {
        let (tracer, tx, mut rx) = street();
        rx[7] = DVec2::splat(50.0);
        let error = trace_links(&tracer, &tx, &rx, &Control::default()).unwrap_err();
        assert!(
            error.chain().starts_with("receiver 7: terminal at"),
            "{error}"
        );
        let error = trace_links(&tracer, &[tx[0], rx[7]], &rx[..3], &Control::default());
        let error = error.unwrap_err().chain();
        assert!(error.starts_with("transmitter 1: terminal at"), "{error}");
        let cancel = AtomicBool::new(true);
        let control = Control {
            cancel: &cancel,
            ..Control::default()
        };
        let error = trace_links(&tracer, &tx, &rx[..3], &control).unwrap_err();
        assert!(matches!(error.cause(), Error::Cancelled));
    }

    #[test]
    fn no_receivers_make_no_links() {
        let (tracer, tx, _) = street();
        let table = trace_links(&tracer, &tx, &[], &Control::default()).unwrap();
        assert_eq!(table.links(), 0);
        let labeler = Labeler::new(&LabelConfig::paper()).unwrap();
        let labels = label_links(&labeler, &table, &Control::default()).unwrap();
        assert_eq!(labels, LinkLabels::default());
    }
}
