//! The report: its sections, in their order.

use aps_metrics::Metric;

use super::analysis::{Analysis, Group, HEADLINE};
use super::claims::claims_of_the_paper;
use super::paper::published;
use super::results::{Entry, TestLink};
use super::{examples, figures, tables};
use crate::chart::Axis;
use crate::document::{Block, Document, Section, Table, Verdict};
use crate::numbers;

/// Width of a class of distances \[m\].
const DISTANCE_STEP_M: f64 = 50.0;

/// Links with this many dominant peaks or more share a group.
const MANY_PEAKS: u32 = 5;

/// The whole report.
pub fn document(analysis: &Analysis<'_>) -> Document {
    let protocol = analysis.main_protocol();
    let results = analysis.results;
    let title = format!("Map2APS benchmark, profile {}", results.profile);
    let mut document = Document::new(title).section(summary(analysis, &protocol));
    document.sections.extend(score_tables(analysis));
    document.sections.push(run_time(analysis, &protocol));
    document.sections.push(strata(analysis, &protocol));
    if !results.examples.is_empty() {
        let mut section = Section::new("Single links");
        for (i, example) in results.examples.iter().enumerate() {
            section.figures(examples::figures(analysis, &protocol, i, example));
        }
        document.sections.push(section);
    }
    if results.entries.iter().any(|e| e.training.is_some()) {
        let mut section = Section::new("Training");
        section.table(tables::training(analysis));
        section.figures(figures::training_curves(analysis).into_iter().collect());
        document.sections.push(section);
    }
    document.section(settings(analysis))
}

fn summary(analysis: &Analysis<'_>, protocol: &str) -> Section {
    let mut section = Section::new("Findings of the paper, asked again");
    for failure in &analysis.results.failed {
        section.verdict(Verdict::decided(false, &failure.name, &failure.message));
    }
    let (verdicts, comparisons) = claims_of_the_paper(analysis, protocol);
    verdicts
        .into_iter()
        .for_each(|verdict| section.verdict(verdict));
    if !comparisons.rows.is_empty() {
        section.table(comparisons);
    }
    section.heading("Models against what learns nothing");
    section.table(tables::against(analysis, protocol));
    section
}

fn score_tables(analysis: &Analysis<'_>) -> Vec<Section> {
    let all: Vec<&Entry> = analysis.results.entries.iter().collect();
    let is_part = |e: &&Entry| published(&e.name).is_some_and(|p| p.ablation.is_some());
    let mut variants: Vec<&Entry> = all.iter().copied().filter(is_part).collect();
    variants.sort_by_key(|e| {
        let parts = published(&e.name).and_then(|p| p.ablation);
        parts.map(|[multi_scale, regularizer]| [regularizer, multi_scale])
    });
    let bootstrap = analysis.bootstrap;
    let mut main = Section::new("Table I: all entries");
    main.text(format!(
        "Means over links; below them the {} % interval of a bootstrap over maps and transmitters ({} replicates, seed {}), and \
         the paper's own figure, of other data and another machine. ms a link: input and prediction, largest batch.",
        numbers::fixed(100.0 * bootstrap.level, 0),
        bootstrap.replicates,
        bootstrap.seed,
    ));
    let mut directions = Section::new("Table II: dominant directions");
    let mut ablation = Section::new("Table III: multi-scale encoder and regularizer");
    for protocol in &analysis.protocols() {
        let scores = |stem: &str, what: &str, entries: &[&Entry], metrics: &[Metric]| {
            let of_labels = match *protocol == analysis.results.data.protocol {
                true => ", the one of the labels",
                false => "",
            };
            let caption = format!("{what}, protocol {protocol}{of_labels}");
            tables::scores(analysis, (stem, caption), entries, protocol, metrics)
        };
        let table = scores("table-1", "Scores over all test links", &all, &tables::MAIN);
        main.table(tables::with_cost(table, analysis, &all));
        directions.table(scores(
            "table-2",
            "Dominant directions",
            &all,
            &tables::DIRECTIONS,
        ));
        let table = scores("table-3", "Ablation", &variants, &tables::ABLATION);
        ablation.table(tables::with_parts(table, &variants));
    }
    let lacking = all.iter().filter(|e| e.substituted_links > 0);
    let links = |e: &&Entry| vec![e.name.clone(), numbers::count(e.substituted_links)];
    let lacking: Vec<Vec<String>> = lacking.map(links).collect();
    if !lacking.is_empty() {
        let caption = "Links without an answer, for which the mean training spectrum was scored";
        main.table(Table::new(caption, ["entry", "links"]).rows(lacking));
    }
    match variants.is_empty() {
        true => vec![main, directions],
        false => vec![main, directions, ablation],
    }
}

fn run_time(analysis: &Analysis<'_>, protocol: &str) -> Section {
    let mut section = Section::new("Error against run time");
    for (i, &batch) in analysis.batches().iter().rev().enumerate() {
        let mut figures = figures::error_against_time(analysis, protocol, batch);
        if i == 0 {
            figures.extend(figures::error_against_training(analysis, protocol));
        }
        section.figures(figures);
    }
    section.table(tables::trade(analysis, protocol));
    section.table(tables::times(analysis));
    section
}

fn strata(analysis: &Analysis<'_>, protocol: &str) -> Section {
    let mut section = Section::new(format!("Groups of links, protocol {protocol}"));
    section.figures(figures::ple_ccdf(analysis, protocol).into_iter().collect());
    let add = |section: &mut Section, (stem, caption), groups: &[Group], metrics: &[Metric]| {
        section.table(tables::groups(
            analysis,
            (stem, caption),
            groups,
            metrics,
            protocol,
        ));
    };
    let figures = |groups: &[Group], key: (&str, Axis), step: f64, is_connected: bool| {
        figures::by_group(analysis, protocol, groups, key, step, is_connected)
    };

    let groups = analysis.groups(by_distance);
    section.heading("By distance");
    let axis = Axis::linear("distance [m]");
    section.figures(figures(&groups, ("distance", axis), DISTANCE_STEP_M, true));
    add(
        &mut section,
        ("by-distance", "Scores by distance"),
        &groups,
        &HEADLINE,
    );

    let groups = analysis.groups(by_sight);
    section.heading("In sight or not");
    let axis = Axis::linear("line of sight (1) or none (0)")
        .over(-0.5, 1.5)
        .every(1.0);
    section.figures(figures(&groups, ("sight", axis), 1.0, false));
    let caption = "Scores in sight and out of sight";
    add(&mut section, ("by-sight", caption), &groups, &HEADLINE);

    let groups = analysis.groups(by_peaks);
    section.heading("By number of dominant peaks");
    let axis = format!("dominant peaks of the truth ({MANY_PEAKS}: or more)");
    let axis = Axis::linear(axis).every(1.0);
    section.figures(figures(&groups, ("peaks", axis), 1.0, true));
    let metrics = [
        Metric::Cosine,
        Metric::PleDeg,
        Metric::Hit2Deg,
        Metric::Hit4Deg,
        Metric::MirrorHit4Deg,
        Metric::Recall2Deg,
        Metric::Recall4Deg,
    ];
    let caption = "Scores by number of dominant peaks";
    add(&mut section, ("by-peaks", caption), &groups, &metrics);

    let groups = analysis.groups(|link| (f64::from(link.map), format!("map {}", link.map)));
    if groups.len() > 1 {
        section.heading("By map");
        let axis = Axis::linear("map").every(1.0);
        section.figures(figures(&groups, ("map", axis), 1.0, false));
    }
    add(
        &mut section,
        ("by-map", "Scores by map"),
        &groups,
        &HEADLINE,
    );
    section
}

fn by_distance(link: &TestLink) -> (f64, String) {
    let class = (link.distance_m / DISTANCE_STEP_M).floor();
    let from = class * DISTANCE_STEP_M;
    let name = format!("{from:.0} to {:.0} m", from + DISTANCE_STEP_M);
    (from + DISTANCE_STEP_M / 2.0, name)
}

fn by_sight(link: &TestLink) -> (f64, String) {
    match link.line_of_sight {
        true => (1.0, "in sight".into()),
        false => (0.0, "out of sight".into()),
    }
}

fn by_peaks(link: &TestLink) -> (f64, String) {
    let peaks = link.dominant_peaks.min(MANY_PEAKS);
    let name = match peaks {
        MANY_PEAKS => format!("{MANY_PEAKS} or more"),
        n => n.to_string(),
    };
    (f64::from(peaks), name)
}

fn settings(analysis: &Analysis<'_>) -> Section {
    let results = analysis.results;
    let (data, machine) = (&results.data, &results.machine);
    let peaks = || results.links.iter().map(|l| l.dominant_peaks);
    let links = results.links.len().max(1) as f64;
    let percent = |count: usize| format!("{} %", numbers::fixed(100.0 * count as f64 / links, 0));
    let mean_peaks = f64::from(peaks().sum::<u32>()) / links;
    let in_sight = results.links.iter().filter(|l| l.line_of_sight).count();
    let maps = |links: u64, ids: &[u32]| {
        let ids: Vec<String> = ids.iter().map(u32::to_string).collect();
        format!(
            "{} links of maps {}",
            numbers::count(links),
            numbers::list(&ids)
        )
    };
    let memory = machine.memory_bytes as f64 / f64::from(1 << 30);
    let commit = match &*machine.commit {
        "" => "unknown",
        commit => commit,
    };
    let cores = format!("{} cores, {} threads", machine.cores, machine.threads);
    let rows = [
        ("maps", data.source.clone()),
        ("protocol of the labels", data.protocol.clone()),
        ("learned from", maps(data.train_links, &data.train_maps)),
        ("best epoch chosen on", maps(data.dev_links, &data.dev_maps)),
        ("scored on", maps(data.test_links, &data.test_maps)),
        (
            "test links without a path, not scored",
            numbers::count(data.invalid_test_links),
        ),
        ("test links in sight", percent(in_sight)),
        (
            "dominant peaks a test link (paper: 2.28)",
            numbers::fixed(mean_peaks, 2),
        ),
        (
            "test links with at most two (paper: 75 %)",
            percent(peaks().filter(|&n| n <= 2).count()),
        ),
        (
            "processor",
            format!(
                "{}, {cores}, {} GiB",
                machine.cpu,
                numbers::fixed(memory, 1)
            ),
        ),
        ("system", machine.os.clone()),
        (
            "version",
            format!("{}, commit {commit}, {}", machine.version, machine.rustc),
        ),
        ("begun", machine.started.clone()),
        ("took", numbers::duration(machine.seconds_total)),
    ];
    let rows = rows.map(|(what, value)| vec![what.to_owned(), value]);
    let mut section = Section::new("Data, machine and settings");
    section.table(Table::new("", ["", "value"]).rows(rows));
    let text = serde_json::to_string_pretty(&results.configuration).unwrap_or_default();
    let title = "All settings".into();
    section.blocks.push(Block::Folded { title, text });
    section
}
