//! Time of preparing terminals, which all links of a terminal share.

use std::collections::HashSet;
use std::time::Instant;

use aps_model::condition::{Link, ModelInput};

use super::time::ms_per_link;
use crate::error::Result;

/// Number of links of a transmitter, and of a receiver, on a map of the paper's size: so many share its preparation.
const SHARED_BY: [f64; 2] = [500.0, 100.0];

/// Most transmitters, and receivers, whose preparation is timed for a size of batch.
const TERMINALS: usize = 256;

/// A link's share of the time for its transmitter and its receiver \[ms\]: all of it where links are asked for one by one.
pub fn shares_ms(batch: usize, terminals_ms: [f64; 2]) -> f64 {
    let shared_by = if batch == 1 { [1.0; 2] } else { SHARED_BY };
    let shares = terminals_ms.iter().zip(shared_by);
    shares.map(|(ms, links)| ms / links).sum()
}

/// Mean time to prepare one transmitter, and one receiver, of some links \[ms\], when so many are prepared at once. The input `fresh`
/// must not have prepared any.
pub fn terminals_ms(fresh: &dyn ModelInput, links: &[Link], at_once: usize) -> Result<[f64; 2]> {
    let (of_transmitters, of_receivers) = one_new_end(links);
    // Every further link of a map shares its other end with these.
    let mut maps = HashSet::new();
    let first = links.iter().filter(|link| maps.insert(link.map));
    let known: Vec<Link> = first.map(exchanged).collect();
    fresh.prepare(&known)?;
    let time = |links: &[Link]| -> Result<f64> {
        let started = Instant::now();
        for some in links.chunks(at_once) {
            fresh.prepare(some)?;
        }
        Ok(ms_per_link(started.elapsed(), links.len().max(1)))
    };
    Ok([time(&of_transmitters)?, time(&of_receivers)?])
}

/// Links by which single terminals can be timed, at most [`TERMINALS`] of each kind. The first have a new transmitter each, and the
/// others a new receiver; their other end is one that an input knows which has seen the first link of each map with its ends exchanged.
fn one_new_end(links: &[Link]) -> (Vec<Link>, Vec<Link>) {
    let firsts = |link: &Link| links.iter().find(|first| first.map == link.map);
    let place = |map: u32, end_m: [f64; 2]| (map, end_m.map(f64::to_bits));
    let (mut tx, mut rx) = (HashSet::new(), HashSet::new());
    let (mut of_tx, mut of_rx) = (Vec::new(), Vec::new());
    for link in links {
        let Some(first) = firsts(link) else { continue };
        if of_tx.len() < TERMINALS && tx.insert(place(link.map, link.tx_m)) {
            of_tx.push(Link {
                rx_m: first.tx_m,
                ..*link
            });
        }
        if of_rx.len() < TERMINALS && rx.insert(place(link.map, link.rx_m)) {
            of_rx.push(Link {
                tx_m: first.rx_m,
                ..*link
            });
        }
    }
    (of_tx, of_rx)
}

fn exchanged(link: &Link) -> Link {
    Link {
        tx_m: link.rx_m,
        rx_m: link.tx_m,
        ..*link
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use aps_model::candle_core::{Device, Tensor};

    use super::*;

    /// Keeps what it is asked to prepare.
    #[derive(Debug, Default)]
    struct Asked(Mutex<Vec<Vec<Link>>>);

    impl ModelInput for Asked {
        fn batch(&self, _: &[Link]) -> aps_model::Result<Tensor> {
            unreachable!("only terminals are prepared");
        }

        fn prepare(&self, links: &[Link]) -> aps_model::Result<()> {
            self.0.lock().unwrap().push(links.to_vec());
            Ok(())
        }

        fn device(&self) -> &Device {
            &Device::Cpu
        }
    }

    /// Three transmitters and four receivers on each of two maps.
    fn grid() -> Vec<Link> {
        let mut links = Vec::new();
        for (map, tx, rx) in (0..24).map(|i| (i / 12, i / 4 % 3, i % 4)) {
            links.push(Link {
                map,
                tx_m: [f64::from(tx), 0.0],
                rx_m: [f64::from(rx), 1.0],
            });
        }
        links
    }

    /// Ends of links that were not asked for before, transmitters and receivers.
    fn new_ends(asked: &[Link], seen: &mut HashSet<(bool, u32, [u64; 2])>) -> [usize; 2] {
        [false, true].map(|is_rx| {
            let end = |link: &Link| if is_rx { link.rx_m } else { link.tx_m };
            let ends = asked.iter();
            let ends = ends.filter(|l| seen.insert((is_rx, l.map, end(l).map(f64::to_bits))));
            ends.count()
        })
    }

    #[test]
    fn each_terminal_is_timed_once_with_nothing_else_to_make() {
        for (at_once, transmitters, receivers) in
            [(1, vec![1; 6], vec![1; 8]), (256, vec![6], vec![8])]
        {
            let input = Asked::default();
            terminals_ms(&input, &grid(), at_once).unwrap();
            let (asked, mut seen) = (input.0.into_inner().unwrap(), HashSet::new());
            let new: Vec<[usize; 2]> = asked.iter().map(|some| new_ends(some, &mut seen)).collect();
            let timed = transmitters.iter().map(|&n| [n, 0]);
            let timed = timed.chain(receivers.iter().map(|&n| [0, n]));
            // Not timed: an end of each kind on each map.
            assert_eq!(new[0], [2, 2]);
            assert_eq!(new[1..], timed.collect::<Vec<_>>());
        }
    }

    #[test]
    fn one_link_pays_for_its_terminals_and_more_for_their_shares() {
        assert_eq!(shares_ms(1, [3.0, 2.0]), 5.0);
        assert_eq!(shares_ms(256, [5.0, 2.0]), 5.0 / 500.0 + 2.0 / 100.0);
    }
}
