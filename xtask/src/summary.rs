//! Closing words about the making of a data set.

use std::fmt;

use map2aps::{Made, counted};

/// Counts and times of what was made.
pub struct Summary<'a>(pub &'a Made);

impl fmt::Display for Summary<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let t = &self.0.tally;
        let valid = t.valid();
        let share = |part: u64, whole: u64| 100.0 * part as f64 / whole.max(1) as f64;
        let seconds = self.0.wall.as_secs_f64();
        if !self.0.repairs.is_empty() {
            let maps = counted(self.0.repairs.len(), "map", "maps");
            writeln!(f, "buildings of {maps} repaired: {}", self.0.all_repairs())?;
        }
        writeln!(f, "links       {:>12}", t.links)?;
        writeln!(f, "  valid     {valid:>12}  {:.3} %", share(valid, t.links))?;
        for (name, count) in t.status.iter().filter(|(name, _)| *name != "valid") {
            let percent = share(*count, t.links);
            writeln!(f, "  {name:<10}{count:>12}  {percent:.3} %")?;
        }
        for (d, count) in &t.fallback {
            let percent = share(*count, t.links);
            let beyond = format!("beyond the limits, {d} diffractions");
            writeln!(f, "  {beyond}: {count}  {percent:.3} %")?;
        }
        let passed_over: u64 = t.passed_over.values().sum();
        if passed_over > 0 {
            let drawn = t.links + passed_over;
            let reasons = t.passed_over.iter();
            let reasons: Vec<String> = reasons.map(|(r, n)| format!("{n} {r}")).collect();
            let (percent, reasons) = (share(passed_over, drawn), reasons.join(", "));
            write!(f, "not reached {passed_over:>12}  {percent:.3} % of ")?;
            writeln!(f, "{drawn} points drawn: {reasons}")?;
        }
        if t.missing_links > 0 {
            writeln!(
                f,
                "missing     {:>12}  links of transmitters that reach too few points; --receivers outdoor keeps links without a path",
                t.missing_links
            )?;
        }
        let a_link = t.paths as f64 / valid.max(1) as f64;
        writeln!(f, "paths       {:>12}  {a_link:.2} a valid link", t.paths)?;
        if let Some((mean, at_most_two)) = t.peaks() {
            writeln!(
                f,
                "dominant peaks: {mean:.2} a valid link, at most two in {:.1} %",
                100.0 * at_most_two
            )?;
        }
        if t.omitted_by_bound + t.omitted_by_gain > 0 {
            let omitted = t.omitted_by_bound + t.omitted_by_gain;
            writeln!(f, "left out    {omitted:>12}  paths too weak")?;
        }
        if t.maps_without_walls + t.maps_without_corners + t.empty_beams > 0 {
            writeln!(
                f,
                "maps that need no reflection: {}, no diffraction: {}; beams that meet no wall: {}",
                t.maps_without_walls, t.maps_without_corners, t.empty_beams
            )?;
        }
        writeln!(f, "bytes       {:>12}", t.bytes)?;
        writeln!(
            f,
            "time        {seconds:>10.2} s  {:.0} links/s, {:.1} us a link",
            t.links as f64 / seconds,
            1e6 * seconds / t.links.max(1) as f64
        )?;
        let stages = [t.prepare, t.trace, t.label, t.write].map(|d| d.as_secs_f64());
        let [prepare, trace, label, write] = stages;
        write!(
            f,
            "thread time: prepare {prepare:.2} s, trace {trace:.2} s, "
        )?;
        write!(f, "label {label:.2} s, write {write:.2} s")
    }
}
