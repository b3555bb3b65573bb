//! `cargo xtask info`: the contents of a data set, as a person wants to read them.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::Result;
use aps_data::{Axis, Layout, MapEntry, Part, Precision, ProfileLayout, Survey};
use indicatif::{DecimalBytes, HumanCount};
use map2aps::maps::ranges;
use serde_json::{Value, json};

use crate::command_line;
use crate::output;

/// Tell what a data set holds, and what an unfinished one lacks.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of the data set.
    dataset: PathBuf,
    /// The same as JSON.
    #[arg(long)]
    json: bool,
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        let survey = Survey::of(&self.dataset)?;
        let facts = Facts::of(&survey);
        let mut out = output::stdout();
        if self.json {
            let mut json = facts.json(&survey);
            json["dataset"] = json!(self.dataset.display().to_string());
            json["continue"] = json!(self.command(&survey));
            writeln!(out, "{}", serde_json::to_string_pretty(&json)?)?;
            return Ok(());
        }
        let state = match (&survey.manifest, survey.missing().len()) {
            (Some(_), _) => "finished".into(),
            (None, missing) => format!(
                "unfinished: {missing} of {} maps are missing",
                survey.wanted().len()
            ),
        };
        writeln!(out, "data set '{}', {state}", self.dataset.display())?;
        facts.write(&survey, &mut out)?;
        if let Some(command) = self.command(&survey) {
            writeln!(out, "\nto continue:\n  {command}")?;
        }
        Ok(())
    }

    /// Command that continues an unfinished data set, if its folder holds the plan.
    fn command(&self, survey: &Survey) -> Option<String> {
        let plan = survey.plan.as_ref().filter(|_| survey.manifest.is_none())?;
        let out = ["--out".into(), self.dataset.display().to_string()];
        Some(command_line::shown(plan.command.iter().cloned().chain(out)))
    }
}

/// Sums over the whole maps.
#[derive(Default)]
struct Facts {
    links: u64,
    paths: u64,
    interactions: u64,
    bytes: u64,
    status: BTreeMap<String, u64>,
    dominant_peaks: BTreeMap<u64, u64>,
    traced_paths: Option<u64>,
    /// Mean and deviation of power relative to the link's largest, over the training maps.
    training: Option<[f64; 2]>,
}

impl Facts {
    fn of(survey: &Survey) -> Self {
        let mut facts = Self::default();
        for map in &survey.maps {
            facts.links += map.links as u64;
            facts.paths += map.paths as u64;
            facts.interactions += map.interactions as u64;
            facts.bytes += map.files.iter().map(|file| file.bytes).sum::<u64>();
            for (name, count) in &map.status {
                *facts.status.entry(name.clone()).or_default() += count;
            }
            if let Some(peaks) = map
                .statistics
                .get("dominant_peaks")
                .and_then(Value::as_object)
            {
                for (peaks, count) in peaks {
                    let (Ok(peaks), Some(count)) = (peaks.parse(), count.as_u64()) else {
                        continue;
                    };
                    *facts.dominant_peaks.entry(peaks).or_default() += count;
                }
            }
            if let Some(paths) = map.statistics.get("paths").and_then(Value::as_u64) {
                *facts.traced_paths.get_or_insert(0) += paths;
            }
        }
        if let Some(manifest) = &survey.manifest {
            let train = manifest.split.maps(Part::Train);
            let maps = survey.maps.iter().filter(|map| train.contains(&map.id));
            facts.training = pooled(maps);
        }
        facts
    }

    fn valid(&self) -> u64 {
        self.status.get("valid").copied().unwrap_or(0)
    }

    /// Dominant peaks a labelled link, and the share of links with at most two.
    fn peaks(&self) -> Option<(f64, f64)> {
        let links: u64 = self.dominant_peaks.values().sum();
        let peaks: u64 = self.dominant_peaks.iter().map(|(n, count)| n * count).sum();
        let at_most_two: u64 = self
            .dominant_peaks
            .range(..=2)
            .map(|(_, count)| count)
            .sum();
        let of_links = |n: u64| n as f64 / links as f64;
        (links > 0).then(|| (of_links(peaks), of_links(at_most_two)))
    }

    fn json(&self, survey: &Survey) -> Value {
        let peaks = self.peaks();
        json!({
            "finished": survey.manifest.is_some(),
            "missing_maps": survey.missing(),
            "maps": survey.maps.iter().map(|map| json!({
                "id": map.id,
                "tx": map.tx,
                "rx": map.rx,
                "links": map.links,
                "status": map.status,
                "statistics": map.statistics,
            })).collect::<Vec<_>>(),
            "links": self.links,
            "status": self.status,
            "stored_paths": self.paths,
            "stored_interactions": self.interactions,
            "bytes": self.bytes,
            "dominant_peaks_a_link": peaks.map(|(mean, _)| mean),
            "share_with_at_most_two_dominant_peaks": peaks.map(|(_, share)| share),
            "training_relative_power": self.training.map(|[mean, std]| json!({ "mean": mean, "std": std })),
            "split": survey.manifest.as_ref().map(|manifest| &manifest.split),
            "seed": survey.config.as_ref().map(|config| config.seed),
            "layout": survey.config.as_ref().map(|config| config.layout),
            "configuration": survey.config.as_ref().map(|config| &config.configuration),
        })
    }

    fn write(&self, survey: &Survey, out: &mut impl Write) -> io::Result<()> {
        let ids: Vec<u32> = survey.maps.iter().map(|map| map.id).collect();
        writeln!(out, "\nmaps   {:>14}  {}", ids.len(), ranges(&ids))?;
        if let Some(manifest) = &survey.manifest {
            for part in Part::ALL {
                let ids = manifest.split.maps(part);
                let name = format!("{part:?}").to_lowercase();
                writeln!(out, "  {name:<8}{:>11}  {}", ids.len(), ranges(ids))?;
            }
        } else {
            let missing = survey.missing();
            writeln!(out, "  missing {:>11}  {}", missing.len(), ranges(&missing))?;
        }
        let count = |n: u64| HumanCount(n).to_string();
        let links = count(self.links);
        writeln!(out, "links  {links:>14}{}", each(&survey.maps))?;
        let share = |n: u64| 100.0 * n as f64 / self.links.max(1) as f64;
        let valid = self.valid();
        let others = self.status.iter().filter(|(name, _)| *name != "valid");
        let others = others.map(|(name, &n)| (name.as_str(), n));
        for (name, n) in [("valid", valid)].into_iter().chain(others) {
            writeln!(out, "  {name:<12}{:>7}  {:.3} %", count(n), share(n))?;
        }
        if let Some(paths) = self.traced_paths {
            let a_link = paths as f64 / valid.max(1) as f64;
            writeln!(out, "paths  {:>14}  {a_link:.2} a valid link", count(paths))?;
        }
        let bytes = DecimalBytes(self.bytes).to_string();
        let a_link = self.bytes as f64 / self.links.max(1) as f64;
        writeln!(out, "size   {bytes:>14}  {a_link:.0} B a link")?;
        if let Some((mean, at_most_two)) = self.peaks() {
            writeln!(
                out,
                "dominant peaks: {mean:.2} a valid link, at most two in {:.1} %",
                100.0 * at_most_two
            )?;
        }
        if let Some([mean, std]) = self.training {
            writeln!(
                out,
                "power relative to the link's largest, training maps: mean {mean:.6}, deviation {std:.6}"
            )?;
        }
        if let Some(config) = &survey.config {
            writeln!(out, "\nstored of each link")?;
            write_layout(&config.layout, out)?;
            writeln!(out, "\nsettings")?;
            writeln!(out, "  seed = {}", config.seed)?;
            write_settings("", &config.configuration, out)?;
        }
        Ok(())
    }
}

/// Terminals a map, where all have the same number.
fn each(maps: &[MapEntry]) -> String {
    let Some(first) = maps.first() else {
        return String::new();
    };
    let is_alike = maps
        .iter()
        .all(|map| (map.tx, map.rx) == (first.tx, first.rx));
    let MapEntry { tx, rx, .. } = *first;
    let is_grid = maps.iter().all(|map| map.links == map.tx * map.rx);
    match (is_alike, is_grid) {
        (true, true) => format!("  {tx} transmitters, {rx} receivers a map"),
        (true, false) => format!("  {tx} transmitters, receivers from {rx} points a map"),
        (false, _) => String::new(),
    }
}

/// Mean and deviation over some maps from those of each.
fn pooled<'m>(maps: impl Iterator<Item = &'m MapEntry>) -> Option<[f64; 2]> {
    let (mut n, mut sum, mut squares) = (0.0, 0.0, 0.0);
    for map in maps {
        let number = |name| map.statistics.get("relative_power")?.get(name)?.as_f64();
        // A map without labels has none.
        if let (Some(values), Some(mean), Some(std)) =
            (number("values"), number("mean"), number("std"))
        {
            n += values;
            sum += values * mean;
            squares += values * (std * std + mean * mean);
        }
    }
    let mean = sum / n;
    (n > 0.0).then(|| [mean, (squares / n - mean * mean).max(0.0).sqrt()])
}

fn write_layout(layout: &Layout, out: &mut impl Write) -> io::Result<()> {
    let profile = |name: &str, unit: &str, place: &str, profile: &ProfileLayout| {
        let Axis {
            start,
            stop,
            count,
            endpoint,
        } = profile.axis;
        let end = if endpoint { "]" } else { ")" };
        let dtype = match profile.dtype {
            Precision::F16 => "half",
            Precision::F32 => "single",
        };
        let argmax = if profile.argmax { place } else { "" };
        format!(
            "  {name}: {count} bins over [{start}, {stop}{end} {unit}, dB in {dtype} precision{argmax}"
        )
    };
    if let Some(aps) = &layout.aps {
        let line = profile(
            "angle power spectrum",
            "deg",
            ", delay of each maximum",
            aps,
        );
        writeln!(out, "{line}")?;
    }
    if let Some(pdp) = &layout.pdp {
        let line = profile("power delay profile", "ns", ", angle of each maximum", pdp);
        writeln!(out, "{line}")?;
    }
    if layout.paths {
        writeln!(out, "  paths: delay, angles, complex gain, interactions")?;
    }
    let grid = layout.raster;
    writeln!(
        out,
        "  of each map: buildings, {} x {} pixels of {} m",
        grid.width, grid.height, grid.metres_per_pixel
    )
}

/// One line a setting.
fn write_settings(path: &str, value: &Value, out: &mut impl Write) -> io::Result<()> {
    match value {
        Value::Object(object) => object.iter().try_for_each(|(key, value)| {
            let dot = if path.is_empty() { "" } else { "." };
            write_settings(&format!("{path}{dot}{key}"), value, out)
        }),
        value => writeln!(out, "  {path} = {value}"),
    }
}
