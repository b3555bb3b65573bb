//! `cargo xtask info`: the contents of a data set, as a person wants to read them.

use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::Result;
use aps_data::{Layout, MapEntry, Part, Plan, Precision, ProfileLayout, Survey};
use aps_label::MeanStd;
use indicatif::{DecimalBytes, HumanCount};
use map2aps::Overview;
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
        let facts = Overview::of(&survey);
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
        write(&facts, &survey, &mut out)?;
        if let Some(command) = self.command(&survey) {
            writeln!(out, "\nto continue:\n  {command}")?;
        }
        Ok(())
    }

    /// Command that continues an unfinished data set, if its folder holds the plan.
    fn command(&self, survey: &Survey) -> Option<String> {
        // A plan of a program that is no command line has no command.
        let is_left = |plan: &&Plan| survey.manifest.is_none() && !plan.command.is_empty();
        let plan = survey.plan.as_ref().filter(is_left)?;
        let out = ["--out".into(), self.dataset.display().to_string()];
        Some(command_line::shown(plan.command.iter().cloned().chain(out)))
    }
}

fn write(facts: &Overview, survey: &Survey, out: &mut impl Write) -> io::Result<()> {
    let ids: Vec<u32> = survey.maps.iter().map(|map| map.id).collect();
    writeln!(out, "\nmaps   {:>14}  {}", ids.len(), ranges(&ids))?;
    if let Some(manifest) = &survey.manifest {
        for part in Part::ALL {
            let ids = manifest.split.maps(part);
            let name = part.name();
            writeln!(out, "  {name:<8}{:>11}  {}", ids.len(), ranges(ids))?;
        }
    } else {
        let missing = survey.missing();
        writeln!(out, "  missing {:>11}  {}", missing.len(), ranges(&missing))?;
    }
    let totals = &survey.totals;
    let count = |n: u64| HumanCount(n).to_string();
    let links = count(totals.links);
    let missing = match facts.missing_links {
        0 => String::new(),
        n => format!("; {} missing: too few points are reached", count(n)),
    };
    writeln!(out, "links  {links:>14}{}{missing}", each(&survey.maps))?;
    let share = |n: u64| 100.0 * n as f64 / totals.links.max(1) as f64;
    let valid = totals.valid();
    let others = totals.status.iter().filter(|(name, _)| *name != "valid");
    let others = others.map(|(name, &n)| (name.as_str(), n));
    for (name, n) in [("valid", valid)].into_iter().chain(others) {
        writeln!(out, "  {name:<12}{:>7}  {:.3} %", count(n), share(n))?;
    }
    if let Some(paths) = facts.traced_paths {
        let a_link = paths as f64 / valid.max(1) as f64;
        writeln!(out, "paths  {:>14}  {a_link:.2} a valid link", count(paths))?;
    }
    let bytes = DecimalBytes(totals.bytes).to_string();
    let a_link = totals.bytes as f64 / totals.links.max(1) as f64;
    writeln!(out, "size   {bytes:>14}  {a_link:.0} B a link")?;
    if let Some((mean, at_most_two)) = facts.dominant_peaks {
        writeln!(
            out,
            "dominant peaks: {mean:.2} a valid link, at most two in {:.1} %",
            100.0 * at_most_two
        )?;
    }
    if let Some(MeanStd { mean, std }) = facts.training {
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

/// Terminals a map, where all have the same number.
fn each(maps: &[MapEntry]) -> String {
    let Some(first) = maps.first() else {
        return String::new();
    };
    let (tx, rx) = (first.tx, first.rx);
    let is_alike = maps.iter().all(|map| (map.tx, map.rx) == (tx, rx));
    let is_grid = maps.iter().all(|map| map.links == map.tx * map.rx);
    match (is_alike, is_grid) {
        (true, true) => format!("  {tx} transmitters, {rx} receivers a map"),
        (true, false) => format!("  {tx} transmitters, receivers from {rx} points a map"),
        (false, _) => String::new(),
    }
}

fn write_layout(layout: &Layout, out: &mut impl Write) -> io::Result<()> {
    let profile = |name: &str, unit: &str, place: &str, profile: &ProfileLayout| {
        let axis = &profile.axis;
        let (count, start, stop) = (axis.count, axis.start, axis.stop);
        let end = if axis.endpoint { "]" } else { ")" };
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
        let place = ", delay of each maximum";
        let line = profile("angle power spectrum", "deg", place, aps);
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
