//! The report: what to say, in which order.

use aps_metrics::Metric;

use super::analysis::{Analysis, HEADLINE};
use super::document::{Block, Document, Part};
use super::paper::published;
use super::results::{Entry, TestLink};
use super::{examples, figures, findings, tables, words};
use crate::chart::Axis;

/// Width of a class of distances \[m\].
const DISTANCE_STEP_M: f64 = 50.0;

/// Links with this many dominant peaks or more share a group.
const MANY_PEAKS: u32 = 5;

/// The whole report.
pub fn document(analysis: &Analysis<'_>) -> Document {
    let protocol = analysis.main_protocol();
    let results = analysis.results;
    let mut parts = vec![summary(analysis, &protocol)];
    parts.extend(score_tables(analysis));
    parts.push(run_time(analysis, &protocol));
    parts.push(baselines(analysis, &protocol));
    parts.push(strata(analysis, &protocol));
    if !results.examples.is_empty() {
        let mut part = Part::new("Single links");
        part.text("The truth is the solid line, normalised as the models learn it.");
        for (i, example) in results.examples.iter().enumerate() {
            part.figures(examples::figures(analysis, &protocol, i, example));
        }
        parts.push(part);
    }
    if results.entries.iter().any(|e| e.training.is_some()) {
        let mut part = Part::new("Training");
        part.blocks.push(Block::Table(tables::training(analysis)));
        part.figures(figures::training_curves(analysis).into_iter().collect());
        parts.push(part);
    }
    parts.push(settings(analysis));
    Document {
        title: format!("Map2APS benchmark, profile {}", results.profile),
        lead: vec![scope(analysis)],
        parts,
    }
}

/// What was compared, on what, in a paragraph.
fn scope(analysis: &Analysis<'_>) -> String {
    let (data, machine) = (&analysis.results.data, &analysis.results.machine);
    let learned = analysis.learned().len();
    let others = analysis.results.entries.len() - learned;
    format!(
        "{learned} {} and {others} {} that learn nothing, scored on {} links of {} {} that no model had seen. \
         Learned from {} links of {} {} ({}). Run on {}, {} {}, begun {}, {} in all.",
        plural(learned, "model", "models"),
        plural(others, "reference", "references"),
        words::count(data.test_links),
        data.test_maps.len(),
        plural(data.test_maps.len(), "map", "maps"),
        words::count(data.train_links),
        data.train_maps.len(),
        plural(data.train_maps.len(), "map", "maps"),
        data.source,
        machine.cpu,
        machine.threads,
        plural(machine.threads, "thread", "threads"),
        machine.started,
        words::duration(machine.seconds_total),
    )
}

fn summary(analysis: &Analysis<'_>, protocol: &str) -> Part {
    let mut part = Part::new("What it says");
    if !analysis.results.failed.is_empty() {
        part.text("Some entries failed and are in no table:");
        let failed = &analysis.results.failed;
        let points = failed.iter().map(|f| format!("{}: {}", f.name, f.message));
        part.blocks.push(Block::Points(points.collect()));
    }
    part.text(format!(
        "Three findings of the paper, asked of these links under the protocol {protocol}. Differences are taken link by \
         link; in brackets their 95 % intervals."
    ));
    for finding in findings::findings(analysis, protocol) {
        part.blocks.push(Block::Heading(format!(
            "{}: {}",
            finding.claim,
            finding.answer.in_words()
        )));
        if !finding.evidence.is_empty() {
            part.blocks.push(Block::Points(finding.evidence));
        }
    }
    let sentences = findings::against_baselines(analysis, protocol);
    if !sentences.is_empty() {
        let heading = "Against baselines that do not look at the map";
        part.blocks.push(Block::Heading(heading.into()));
        part.blocks.push(Block::Points(sentences));
    }
    part
}

fn score_tables(analysis: &Analysis<'_>) -> Vec<Part> {
    let all: Vec<&Entry> = analysis.results.entries.iter().collect();
    let protocols = analysis.protocols();
    let labels = &analysis.results.data.protocol;
    let named = |what: &str, protocol: &str| {
        let of_labels = if protocol == labels {
            ", the one of the labels"
        } else {
            ""
        };
        format!("{what}, protocol {protocol}{of_labels}")
    };

    let mut main = Part::new("Table I: all entries");
    main.text(intervals(analysis));
    main.text(
        "Lines that begin with \u{201c}paper\u{201d} give the paper's own figures: another data set, its full scale, \
         another machine. They are there for the order of the models, not as a target. The best of what was learned is \
         set in bold.",
    );
    let mut directions = Part::new("Table II: dominant directions");
    directions.text(
        "A uniform linear array cannot tell a direction from its mirror image, so that Hit, which asks for the strongest \
         peak, is near a half for a perfect shape; the mirror hits accept the twin.",
    );
    for protocol in &protocols {
        let caption = named("Scores over all test links", protocol);
        let grid = tables::scores(
            analysis,
            ("table-1", caption),
            &all,
            protocol,
            &tables::MAIN,
        );
        main.blocks
            .push(Block::Table(tables::with_cost(grid, analysis, &all)));
        let caption = named("Dominant directions", protocol);
        let grid = tables::scores(
            analysis,
            ("table-2", caption),
            &all,
            protocol,
            &tables::DIRECTIONS,
        );
        directions.blocks.push(Block::Table(grid));
    }
    if let Some(&batch) = analysis.batches().last() {
        main.text(format!(
            "ms a link: building of the input and prediction in batches of {batch}, median; of what was timed with one size \
             only, that one."
        ));
    }
    for sentence in substituted(analysis) {
        main.text(sentence);
    }
    let mut parts = vec![main, directions];

    let is_part = |e: &&Entry| published(&e.name).is_some_and(|p| p.ablation.is_some());
    let mut variants: Vec<&Entry> = all.iter().copied().filter(is_part).collect();
    variants.sort_by_key(|e| {
        published(&e.name)
            .and_then(|p| p.ablation)
            .map(|[ms, reg]| [reg, ms])
    });
    if !variants.is_empty() {
        let mut part = Part::new("Table III: multi-scale encoder and regularizer");
        for protocol in &protocols {
            let caption = named("Ablation", protocol);
            let grid = tables::scores(
                analysis,
                ("table-3", caption),
                &variants,
                protocol,
                &tables::ABLATION,
            );
            part.blocks
                .push(Block::Table(tables::with_parts(grid, &variants)));
        }
        parts.push(part);
    }
    parts
}

fn intervals(analysis: &Analysis<'_>) -> String {
    let bootstrap = analysis.bootstrap;
    let maps = analysis.results.data.test_maps.len();
    let caution = match maps {
        0 | 1 => " With a single test map they say nothing of how different another map would be."
            .to_owned(),
        2..=9 => format!(" With {maps} test maps they are somewhat too narrow."),
        _ => String::new(),
    };
    format!(
        "Each cell holds the mean over links and below it the {} % interval of a bootstrap over maps and the transmitters in \
         them ({} replicates, seed {}): links of one transmitter are not independent.{caution}",
        words::fixed(100.0 * bootstrap.level, 0),
        bootstrap.replicates,
        bootstrap.seed,
    )
}

fn substituted(analysis: &Analysis<'_>) -> Vec<String> {
    let all = analysis.results.links.len() as u64;
    let lacking = analysis
        .results
        .entries
        .iter()
        .filter(|e| e.substituted_links > 0);
    lacking
        .map(|e| {
            format!(
                "{} has no answer for {} of {} links; there the mean training spectrum was scored.",
                e.name,
                words::count(e.substituted_links),
                words::count(all)
            )
        })
        .collect()
}

fn run_time(analysis: &Analysis<'_>, protocol: &str) -> Part {
    let mut part = Part::new("Error against run time");
    part.text(
        "The tracer's entries are scored against labels that the same tracer made with higher limits: they say what lower \
         limits lose, not how true the tracer is. Lower limits cost less time, and a model is worth its training where it \
         lies on the front.",
    );
    let batches = analysis.batches();
    for (i, &batch) in batches.iter().rev().enumerate() {
        let mut figures = figures::error_against_time(analysis, protocol, batch);
        if i == 0 {
            figures.extend(figures::error_against_training(analysis, protocol));
        }
        part.figures(figures);
    }
    part.blocks
        .push(Block::Table(tables::trade(analysis, protocol)));
    part.blocks.push(Block::Table(tables::times(analysis)));
    part
}

fn baselines(analysis: &Analysis<'_>, protocol: &str) -> Part {
    let mut part = Part::new("Models against what learns nothing");
    part.blocks
        .push(Block::Table(tables::against(analysis, protocol)));
    let sentences = findings::against_tracer(analysis, protocol);
    if !sentences.is_empty() {
        part.blocks.push(Block::Points(sentences));
    }
    part
}

fn strata(analysis: &Analysis<'_>, protocol: &str) -> Part {
    let mut part = Part::new("Where the errors are");
    part.text(format!(
        "Under the protocol {protocol}. Curves of baselines and of the tracer are dashed; of the tracer the setting with the \
         best CosSim is drawn. The tables hold all entries."
    ));
    part.figures(figures::ple_ccdf(analysis, protocol).into_iter().collect());

    let table = |stem: &str, caption: &str, groups: &[_], metrics: &[Metric]| {
        Block::Table(tables::groups(
            analysis,
            (stem, caption.into()),
            groups,
            metrics,
            protocol,
        ))
    };
    let groups = analysis.groups(by_distance);
    part.blocks.push(Block::Heading("By distance".into()));
    let axis = Axis::linear("distance [m]");
    part.figures(figures::by_group(
        analysis,
        protocol,
        &groups,
        ("distance", axis),
        DISTANCE_STEP_M,
        true,
    ));
    part.blocks.push(table(
        "by-distance",
        "Scores by distance",
        &groups,
        &HEADLINE,
    ));

    let groups = analysis.groups(by_sight);
    part.blocks.push(Block::Heading("In sight or not".into()));
    part.figures(figures::by_sight(analysis, protocol, &groups));
    part.blocks.push(table(
        "by-sight",
        "Scores in sight and out of sight",
        &groups,
        &HEADLINE,
    ));

    let groups = analysis.groups(by_peaks);
    part.blocks
        .push(Block::Heading("By number of dominant peaks".into()));
    let axis = Axis::linear(format!(
        "dominant peaks of the truth ({MANY_PEAKS}: or more)"
    ))
    .every(1.0);
    part.figures(figures::by_group(
        analysis,
        protocol,
        &groups,
        ("peaks", axis),
        1.0,
        true,
    ));
    let metrics = [
        Metric::Cosine,
        Metric::PleDeg,
        Metric::Hit2Deg,
        Metric::Hit4Deg,
        Metric::MirrorHit4Deg,
        Metric::Recall2Deg,
        Metric::Recall4Deg,
    ];
    part.blocks.push(table(
        "by-peaks",
        "Scores by number of dominant peaks",
        &groups,
        &metrics,
    ));

    let groups = analysis.groups(|link| (f64::from(link.map), format!("map {}", link.map)));
    if groups.len() > 1 {
        part.blocks.push(Block::Heading("By map".into()));
        let axis = Axis::linear("map").every(1.0);
        part.figures(figures::by_group(
            analysis,
            protocol,
            &groups,
            ("map", axis),
            1.0,
            false,
        ));
    }
    part.blocks
        .push(table("by-map", "Scores by map", &groups, &HEADLINE));
    part
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

fn settings(analysis: &Analysis<'_>) -> Part {
    let results = analysis.results;
    let (data, machine) = (&results.data, &results.machine);
    let mut part = Part::new("Data, machine and settings");
    let peaks = || results.links.iter().map(|l| l.dominant_peaks);
    let links = results.links.len().max(1) as f64;
    let at_most_two = peaks().filter(|&n| n <= 2).count() as f64 / links;
    let mean_peaks = f64::from(peaks().sum::<u32>()) / links;
    let in_sight = results.links.iter().filter(|l| l.line_of_sight).count() as f64 / links;
    let maps = |ids: &[u32]| match ids {
        [] => "none".to_owned(),
        ids => words::list(&ids.iter().map(u32::to_string).collect::<Vec<_>>()),
    };
    let memory = machine.memory_bytes as f64 / f64::from(1 << 30);
    let commit = match &*machine.commit {
        "" => "unknown".to_owned(),
        commit => commit.to_owned(),
    };
    part.blocks.push(Block::Points(vec![
        format!("Maps: {}; labels of the protocol {}.", data.source, data.protocol),
        format!("Learned from {} links of the maps {}.", words::count(data.train_links), maps(&data.train_maps)),
        format!(
            "Best epoch chosen on {} links of the maps {}.",
            words::count(data.dev_links),
            maps(&data.dev_maps)
        ),
        format!(
            "Scored on {} links of the maps {}; {} more had no path, thus no label, and are not scored.",
            words::count(data.test_links),
            maps(&data.test_maps),
            words::count(data.invalid_test_links)
        ),
        format!(
            "{} % of the test links have at most two dominant peaks, {} on average (paper: 75 % and 2.28); {} % are in sight.",
            words::fixed(100.0 * at_most_two, 0),
            words::fixed(mean_peaks, 2),
            words::fixed(100.0 * in_sight, 0)
        ),
        format!(
            "Machine: {}, {} cores, {} threads, {} GiB, {}.",
            machine.cpu,
            machine.cores,
            machine.threads,
            words::fixed(memory, 1),
            machine.os
        ),
        format!("Version {}, commit {commit}, {}.", machine.version, machine.rustc),
        format!("Begun {}; {} in all.", machine.started, words::duration(machine.seconds_total)),
    ]));
    let text = serde_json::to_string_pretty(&results.configuration).unwrap_or_default();
    part.blocks.push(Block::Folded("All settings".into(), text));
    part
}

fn plural<'a>(n: usize, one: &'a str, many: &'a str) -> &'a str {
    if n == 1 { one } else { many }
}
