//! The tables of a report: the one in front, and those that are folded.

use aps_metrics::{Better, Metric};

use super::analysis::{self, Analysis, Group};
use super::paper::published;
use super::results::{Entry, EntryKind, MEAN, TestLink};
use super::words::{self, or_nothing};
use crate::document::Table;
use crate::numbers::{count, duration, fixed, list, stem, three_digits};

/// Most rows of the table in front.
const ROWS: usize = 12;

/// Columns of groups of links.
const GROUPED: [Metric; 4] = [
    Metric::Cosine,
    Metric::Mae,
    Metric::PleDeg,
    Metric::Recall4Deg,
];

/// Width of a class of distances \[m\].
const DISTANCE_STEP_M: f64 = 50.0;

/// Links with this many dominant peaks or more share a group.
const MANY_PEAKS: u32 = 5;

/// Place and name of the group of a link.
type GroupOf = fn(&TestLink) -> (f64, String);

/// The heading of a column, and those of its values in the CSV.
type Column = (String, Vec<String>);

/// A cell as it is read, and as the values of its CSV.
type Cell = (String, Vec<String>);

/// A table with a CSV file.
fn table(
    stem: &str,
    caption: impl Into<String>,
    columns: &[Column],
    rows: impl IntoIterator<Item = Vec<Cell>>,
) -> Table {
    let keys = columns.iter().flat_map(|c| c.1.clone()).collect();
    let mut table = Table::new(caption, columns.iter().map(|c| c.0.clone()))
        .with_data(format!("tables/{stem}.csv"), vec![keys]);
    for row in rows {
        let (shown, values): (Vec<String>, Vec<Vec<String>>) = row.into_iter().unzip();
        table.push(shown);
        table.data.push(values.concat());
    }
    table
}

fn column(heading: &str, key: &str) -> Column {
    (heading.into(), vec![key.into()])
}

fn text(text: impl Into<String>) -> Cell {
    let text = text.into();
    (text.clone(), vec![text])
}

fn number<T: ToString + Copy>(value: Option<T>, shown: impl Fn(T) -> String) -> Cell {
    let digits = value.map(|v| v.to_string()).unwrap_or_default();
    (or_nothing(value.map(shown)), vec![digits])
}

fn metric_column(metric: Metric) -> Column {
    let keys = ["", "_low", "_high"].map(|end| format!("{}{end}", metric.key()));
    (words::heading(metric), keys.into())
}

fn estimate(metric: Metric, of: Option<aps_metrics::Estimate>) -> Cell {
    let ends = [of.map(|m| m.mean), of.map(|m| m.low), of.map(|m| m.high)];
    let digits = ends.map(|x| x.map(|x| x.to_string()).unwrap_or_default());
    (
        or_nothing(of.map(|m| words::estimate(metric, &m))),
        digits.into(),
    )
}

/// The entries that the table in front shows, and the others: all models and the mean spectrum, then as many as there is room for of
/// weights and predictions from elsewhere, the best of the tracer, the other baselines, and the rest of the tracer. Both by falling CosSim.
fn in_front<'a>(analysis: &Analysis<'a>, protocol: &str) -> [Vec<&'a Entry>; 2] {
    let ranked = analysis.ranked(protocol, Metric::Cosine);
    let best_tracer = ranked.iter().find(|e| e.kind == EntryKind::Tracer);
    let best_tracer = best_tracer.map(|e| &*e.name);
    let rank = |entry: &Entry| match entry.kind {
        EntryKind::Model => 0,
        EntryKind::Baseline if entry.name == MEAN => 0,
        EntryKind::Shipped => 1,
        EntryKind::External => 2,
        EntryKind::Tracer if best_tracer == Some(&*entry.name) => 3,
        EntryKind::Baseline => 4,
        EntryKind::Ceiling => 5,
        EntryKind::Tracer => 6,
    };
    // The sort is stable: within a rank the best come first.
    let mut first = ranked.clone();
    first.sort_by_key(|entry| rank(entry));
    first.truncate(ROWS);
    let is_in_front = |entry: &&Entry| first.iter().any(|other| other.name == entry.name);
    let (front, rest) = ranked.into_iter().partition(is_in_front);
    [front, rest]
}

/// The entries in front with what they cost, the best in CosSim first, and a folded table of the others if there are some.
pub fn front(analysis: &Analysis<'_>, protocol: &str) -> (Table, Option<Table>) {
    let [front, rest] = in_front(analysis, protocol);
    let links = analysis.results.links.len() as u64;
    let caption = format!(
        "{} links of test maps, protocol {protocol}, means with 95 % intervals, the best in CosSim first; Rec.@4 is high \
         for a nearly flat spectrum too",
        count(links)
    );
    let front = with_costs(analysis, protocol, "front", &caption, &front);
    let others = || with_costs(analysis, protocol, "others", "All other entries", &rest);
    (front, (!rest.is_empty()).then(|| others().folded()))
}

/// Entries with the metrics in front and what they cost.
fn with_costs(
    analysis: &Analysis<'_>,
    protocol: &str,
    stem: &str,
    caption: &str,
    entries: &[&Entry],
) -> Table {
    const METRICS: [Metric; 3] = [Metric::Cosine, Metric::Recall4Deg, Metric::Mae];
    let mut columns = vec![column("entry", "entry")];
    columns.extend(METRICS.map(metric_column));
    let keys = ["ms_per_link_one", "ms_per_link_many"].map(String::from);
    columns.push(("ms a link \u{2193}".into(), keys.into()));
    columns.push(column("training", "training_seconds"));
    let row = |entry: &&Entry| {
        let times = analysis::times(entry);
        let [first, last] = [times.first(), times.last()].map(|t| t.copied());
        let one = first.filter(|_| times.len() > 1);
        let below = one.map(|one| format!("\none at a time {}", three_digits(one)));
        let shown = last.map(|last| three_digits(last) + &below.unwrap_or_default());
        let digits = [one, last].map(|t| t.map(|t| t.to_string()).unwrap_or_default());
        let mut row = vec![text(&*entry.name)];
        row.extend(METRICS.map(|m| estimate(m, analysis.mean(entry, protocol, m))));
        row.push((or_nothing(shown), digits.into()));
        row.push(number(entry.training.as_ref().map(|t| t.seconds), duration));
        row
    };
    table(stem, caption, &columns, entries.iter().map(row))
}

/// The paper's Tables I to III: means, an entry a row, the paper's figure below each. The best of what was learned stands out.
pub fn scores(analysis: &Analysis<'_>, protocol: &str) -> Table {
    let metrics = [&Metric::PAPER_COLUMNS[..], &Metric::MIRROR_COLUMNS].concat();
    let entries = &analysis.results.entries;
    let mut columns = vec![column("entry", "entry")];
    columns.extend(metrics.iter().copied().map(metric_column));
    let row = |entry: &Entry| {
        let cell = |&metric: &Metric| {
            let (mut shown, data) = estimate(metric, analysis.mean(entry, protocol, metric));
            if let Some(paper) = published(&entry.name).and_then(|p| p.of(metric)) {
                shown += &format!("\npaper {}", words::value(metric, paper));
            }
            (shown, data)
        };
        let mut row = vec![text(&*entry.name)];
        row.extend(metrics.iter().map(cell));
        row
    };
    let caption = format!("Tables I to III of the paper, all entries, protocol {protocol}");
    let name = stem(&format!("scores-{protocol}"));
    let mut table = table(&name, caption, &columns, entries.iter().map(row)).folded();
    for (j, &metric) in metrics.iter().enumerate() {
        let mean = |e: &Entry| Some(analysis.mean(e, protocol, metric)?.mean);
        let learned = |e: &Entry| mean(e).filter(|_| e.kind.is_learned());
        let values = entries.iter().filter_map(learned);
        let best = match metric.better() {
            Better::Lower => values.fold(f64::INFINITY, f64::min),
            Better::Higher => values.fold(f64::NEG_INFINITY, f64::max),
        };
        let places = entries.iter().enumerate();
        let places = places.filter(|(_, e)| learned(e) == Some(best));
        table.best.extend(places.map(|(i, _)| (i, j + 1)));
    }
    table
}

/// Scores by distance, sight, number of dominant peaks, and map.
pub fn groups(analysis: &Analysis<'_>, protocol: &str) -> Table {
    let ways: [GroupOf; 4] = [
        |link| {
            let from = (link.distance_m / DISTANCE_STEP_M).floor() * DISTANCE_STEP_M;
            let to = from + DISTANCE_STEP_M;
            (from, format!("{from:.0} to {to:.0} m"))
        },
        |link| match link.line_of_sight {
            true => (1.0, "in sight".into()),
            false => (0.0, "out of sight".into()),
        },
        |link| match link.dominant_peaks.min(MANY_PEAKS) {
            MANY_PEAKS => (f64::from(MANY_PEAKS), format!("{MANY_PEAKS} peaks or more")),
            n => (f64::from(n), format!("peaks: {n}")),
        },
        |link| (f64::from(link.map), format!("map {}", link.map)),
    ];
    let groups: Vec<Group> = ways.iter().flat_map(|way| analysis.groups(way)).collect();
    let mut columns = ["entry", "group", "links"].map(|c| column(c, c)).to_vec();
    columns.extend(GROUPED.map(metric_column));
    let entries = analysis.results.entries.iter();
    let pairs = entries.flat_map(|entry| groups.iter().map(move |group| (entry, group)));
    let rows = pairs.map(|(entry, group)| {
        let mean = |metric| analysis.mean_in(group, entry, protocol, metric);
        let mut row = vec![text(&*entry.name), text(&*group.name)];
        row.push(number(Some(group.links.len() as u64), count));
        row.extend(GROUPED.map(|metric| estimate(metric, mean(metric))));
        row
    });
    let caption = format!("Scores by distance, sight, dominant peaks and map, protocol {protocol}");
    table("groups", caption, &columns, rows).folded()
}

/// Run times of all entries.
pub fn times(analysis: &Analysis<'_>) -> Table {
    let columns = [
        column("entry", "entry"),
        column("batch", "batch"),
        column("device", "device"),
        column("prediction [ms]", "median_ms_per_link"),
        column("p95 [ms]", "p95_ms_per_link"),
        column("input [ms]", "input_ms_per_link"),
        column("sum [ms]", "total_ms_per_link"),
    ];
    let of_entry = |entry: &Entry| {
        let ms = |ms: f64| number(Some(ms), three_digits);
        let row = |l: &super::Latency| {
            vec![
                text(&*entry.name),
                text(l.batch.to_string()),
                text(&*l.device),
                ms(l.median_ms_per_link),
                ms(l.p95_ms_per_link),
                ms(l.input_ms_per_link),
                ms(l.total_ms_per_link()),
            ]
        };
        entry.latency.iter().map(row).collect::<Vec<_>>()
    };
    let threads = analysis.results.machine.threads;
    let caption = format!(
        "Time a link in use, {threads} threads: median and 95th percentile of the prediction, and its input"
    );
    let rows = analysis.results.entries.iter().flat_map(of_entry);
    table("time", caption, &columns, rows).folded()
}

/// Costs and settings of training.
pub fn training(analysis: &Analysis<'_>) -> Table {
    let columns = [
        column("entry", "entry"),
        column("parameters", "parameters"),
        column("time", "seconds"),
        column("epochs", "epochs"),
        column("links seen", "links_seen"),
        column("links a step", "batch"),
        column("learning rate", "learning_rate"),
        column("pixels", "image_size"),
        column("steps to the best weights", "best_steps"),
    ];
    let row = |entry: &Entry| {
        let t = entry.training.as_ref()?;
        Some(vec![
            text(&*entry.name),
            number(entry.parameters, count),
            number(Some(t.seconds), duration),
            number(Some(t.epochs), |e| fixed(e, 1)),
            number(Some(t.links_seen), count),
            text(t.batch.to_string()),
            text(t.learning_rate.to_string()),
            text(t.image_size.to_string()),
            number(t.best_steps, count),
        ])
    };
    let rows = analysis.results.entries.iter().filter_map(row);
    table("training", "Training", &columns, rows).folded()
}

/// Data and machine.
pub fn conditions(analysis: &Analysis<'_>) -> Table {
    let results = analysis.results;
    let (data, machine) = (&results.data, &results.machine);
    let peaks = || results.links.iter().map(|l| l.dominant_peaks);
    let links = results.links.len().max(1) as f64;
    let percent = |count: usize| format!("{} %", fixed(100.0 * count as f64 / links, 0));
    let in_sight = results.links.iter().filter(|l| l.line_of_sight).count();
    let maps = |links: u64, ids: &[u32]| {
        let ids: Vec<String> = ids.iter().map(u32::to_string).collect();
        format!("{} links of maps {}", count(links), list(&ids))
    };
    let memory = machine.memory_bytes as f64 / f64::from(1 << 30);
    let commit = match &*machine.commit {
        "" => "unknown",
        commit => commit,
    };
    let substituted = results.entries.iter().filter(|e| e.substituted_links > 0);
    let substituted: Vec<String> = substituted
        .map(|e| format!("{} {}", e.name, count(e.substituted_links)))
        .collect();
    let chosen_by = Metric::ALL.iter().find(|m| m.key() == data.chosen_by);
    let chosen_by = chosen_by.map_or(String::new(), |m| format!(", by mean {}", m.label()));
    let bootstrap = analysis.bootstrap;
    let rows = [
        ("maps", data.source.clone()),
        ("protocol of the labels", data.protocol.clone()),
        ("learned from", maps(data.train_links, &data.train_maps)),
        (
            "best weights chosen on",
            maps(data.dev_links, &data.dev_maps) + &chosen_by,
        ),
        ("scored on", maps(data.test_links, &data.test_maps)),
        (
            "test links without a path, not scored",
            count(data.invalid_test_links),
        ),
        (
            "links without an answer, the mean spectrum scored",
            list(&substituted),
        ),
        ("test links in sight", percent(in_sight)),
        (
            "dominant peaks a test link (paper: 2.28)",
            fixed(peaks().map(f64::from).sum::<f64>() / links, 2),
        ),
        (
            "test links with at most two (paper: 75 %)",
            percent(peaks().filter(|&n| n <= 2).count()),
        ),
        (
            "intervals",
            format!(
                "{} %, bootstrap over maps and transmitters, {} replicates, seed {}",
                fixed(100.0 * bootstrap.level, 0),
                bootstrap.replicates,
                bootstrap.seed
            ),
        ),
        (
            "processor",
            format!(
                "{}, {} cores, {} threads, {} GiB",
                machine.cpu,
                machine.cores,
                machine.threads,
                fixed(memory, 1)
            ),
        ),
        ("system", machine.os.clone()),
        (
            "version",
            format!("{}, commit {commit}, {}", machine.version, machine.rustc),
        ),
        ("begun", machine.started.clone()),
        ("took", duration(machine.seconds_total)),
    ];
    let columns = [column("", "what"), column("value", "value")];
    let rows = rows.map(|(what, value)| vec![text(what), text(value)]);
    table("conditions", "Data and machine", &columns, rows).folded()
}
