//! The smallest benchmark, run again with changes.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use aps_bench::{Benchmark, Config, Error, Event, Observer, Profile, Watch};
use aps_data::npy;
use aps_model::ModelKind;
use aps_report::benchmark::{Entry, EntryKind, Results, ScoreTable};
use map2aps::Progress;
use tempfile::TempDir;

/// The entries of the weights that come with the program.
const SHIPPED: [&str; 2] = ["MS-AReg, shipped", "Polar-Reg, shipped"];

#[track_caller]
fn results(out: &Path, file: Option<&Path>, more: &str) -> Results {
    watched(out, file, more, Watch::default())
}

#[track_caller]
fn watched(out: &Path, file: Option<&Path>, more: &str, watch: Watch<'_>) -> Results {
    let config = Config::resolve(Profile::Smoke, file, more.parse().unwrap()).unwrap();
    let profile = config.profile_name(Profile::Smoke);
    let mut bench = Benchmark::new(config, out).unwrap();
    bench.profile = profile.into();
    bench.run(watch).unwrap();
    // What was written, which is what was given.
    Results::load(out).unwrap()
}

fn entry<'a>(results: &'a Results, name: &str) -> &'a Entry {
    let found = results.entries.iter().find(|e| e.name == name);
    found.unwrap_or_else(|| panic!("no entry {name}: {:?}", results.failed))
}

fn table(results: &Results, out: &Path, name: &str) -> ScoreTable {
    let scores = &entry(results, name).scores[0];
    ScoreTable::read(out, scores, results.links.len()).unwrap()
}

fn mean_cosine(results: &Results, out: &Path, name: &str) -> f64 {
    let table = table(results, out, name);
    table.mean(aps_metrics::Metric::Cosine).unwrap()
}

#[test]
fn smoke_benchmark_is_whole_and_reused() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("bench");
    let first = results(&out, None, "");
    is_whole(&first, &out);

    // One model made to fail, one's own predictions and weights from outside: the other is not trained again.
    let copy = folder.path().join("own.npy");
    fs::copy(out.join("scores/resnet-mlp/prediction.npy"), &copy).unwrap();
    let config = folder.path().join("bench.toml");
    fs::write(&config, "[model.ms_areg]\nlearning_rate = -1.0\n").unwrap();
    let external = format!("external.own = '{}'", copy.display());
    let best = out.join("models/resnet_mlp/best.safetensors");
    let weights = format!("weights.weights = '{}'", best.display());
    let models = "models = ['resnet_mlp', 'ms_areg']";
    let more = [models, &external, &weights].join("\n");
    let second = results(&out, Some(&config), &more);
    assert_eq!(second.profile, "custom");
    assert_eq!(entry(&second, "ResNet-MLP"), entry(&first, "ResNet-MLP"));
    let trained = table(&first, &out, "ResNet-MLP");
    assert_eq!(table(&second, &out, "own"), trained);
    assert_eq!(entry(&second, "own").kind, EntryKind::External);
    let weights = entry(&second, "weights");
    assert_eq!(weights.kind, EntryKind::Shipped);
    assert_eq!(weights.training, None);
    assert_eq!(table(&second, &out, "weights"), trained);
    let [failure] = &second.failed[..] else {
        panic!("{:?}", second.failed);
    };
    assert_eq!(failure.name, "MS-AReg");
    let is_told = failure.message.contains("learning_rate");
    assert!(is_told, "{}", failure.message);
    let html = fs::read_to_string(out.join("report.html")).unwrap();
    let is_told = html.contains("learning_rate");
    assert!(is_told, "the report tells what failed");

    // Weights alone do not tell the size of their images.
    let alone = folder.path().join("alone.safetensors");
    fs::copy(&best, &alone).unwrap();
    let weights = format!("weights.alone = '{}'", alone.display());
    let (more, assumed) = ([models, &weights].join("\n"), Assumed::default());
    let watch = Watch {
        observer: &assumed,
        ..Watch::default()
    };
    let told = watched(&out, Some(&config), &more, watch);
    assert_eq!(entry(&told, "alone").kind, EntryKind::Shipped);
    assert_eq!(assumed.0.into_inner(), 64);

    // Predictions of other links are refused, and nothing else suffers.
    let other = folder.path().join("other.npy");
    fs::rename(&copy, &other).unwrap();
    fs::write(map2aps::links_file(&other), "row,map,link\n0,0,0\n").unwrap();
    npy::write(&copy, &[2, 180], &[0.0_f32; 360]).unwrap();
    let other = format!("external.other = '{}'", other.display());
    let more = ["models = ['resnet_mlp']", &external, &other].join("\n");
    let third = results(&out, None, &more);
    for (name, told) in [("own", "2 spectra"), ("other", "other links, from row 0")] {
        let is_told =
            |f: &aps_report::benchmark::Failure| f.name == name && f.message.contains(told);
        assert!(third.failed.iter().any(is_told), "{:?}", third.failed);
    }
    assert!(!third.entries.iter().any(|e| e.name == "MS-AReg"));
}

#[track_caller]
fn is_whole(results: &Results, out: &Path) {
    assert_eq!(results.profile, "smoke");
    assert!(results.failed.is_empty(), "{:?}", results.failed);
    let data = &results.data;
    assert_eq!((data.train_maps.len(), data.test_maps.len()), (2, 1));
    assert_eq!(data.test_links + data.invalid_test_links, 36);
    assert_eq!(results.links.len() as u64, data.test_links);
    assert_eq!(results.examples.len(), 3);
    assert!(results.machine.seconds_total > 0.0);
    for kind in ModelKind::ALL {
        let model = entry(results, kind.title());
        let training = model.training.as_ref().unwrap();
        let times: Vec<f64> = training.curve.iter().map(|p| p.seconds).collect();
        assert!(times.len() == 2 && times.is_sorted());
        assert!(training.seconds > 0.0, "{times:?}");
        assert!(training.links_seen > 0);
        // Weights are chosen by the metric that entries are ranked by; of equals the first.
        let cosines = training.curve.iter().filter_map(|p| p.dev_cosine);
        let highest = cosines.fold(f64::NEG_INFINITY, f64::max);
        let best = training.curve.iter();
        let best = best.filter(|p| p.dev_cosine == Some(highest));
        assert_eq!(training.best_steps, best.map(|p| p.steps).min(), "{kind}");
        let batches: Vec<usize> = model.latency.iter().map(|l| l.batch).collect();
        assert_eq!(batches, [1, 16]);
        let mut times = model.latency.iter();
        assert!(times.all(|l| l.p95_ms_per_link >= l.median_ms_per_link));
    }
    let shipped = |e: &&Entry| e.kind == EntryKind::Shipped;
    let shipped = results.entries.iter().filter(shipped);
    assert!(shipped.map(|e| &*e.name).eq(SHIPPED));
    assert!(results.left_out.is_empty(), "{:?}", results.left_out);
    // The tracer scores better with more of the interactions that the labels are made of.
    let cosine = |name| mean_cosine(results, out, name);
    assert!(cosine("tracer, 2 interactions") > cosine("tracer, 0 interactions"));
    assert!(cosine("tracer, 2 interactions") > cosine("mean spectrum"));
    // One path of each link, none of which lacks one: more than what is in sight, less than all.
    let strongest = cosine("strongest path");
    assert!(strongest > cosine("tracer, 0 interactions") && strongest < 0.999_999);
    assert_eq!(entry(results, "strongest path").substituted_links, 0);
    let shipped = entry(results, "Polar-Reg, shipped");
    assert_eq!(shipped.model.as_deref(), Some("Polar-Reg"));
    // The labels' own limits.
    assert!(cosine("tracer, 7 interactions") > 0.999_999);
    let in_sight = results.links.iter().filter(|l| l.line_of_sight).count() as u64;
    let direct = entry(results, "tracer, 0 interactions");
    assert_eq!(direct.substituted_links, data.test_links - in_sight);
    for file in ["report.html", "report.md", "configuration.json"] {
        assert!(out.join(file).is_file(), "{file}");
    }
}

/// Keeps the size of images that was assumed last.
#[derive(Default)]
struct Assumed(AtomicUsize);

impl Progress for Assumed {}

impl Observer for Assumed {
    fn event(&self, event: Event<'_>) {
        if let Event::ImagesAssumed(size) = event {
            self.0.store(size, Ordering::Relaxed);
        }
    }
}

/// Ends the work when the second training begins.
#[derive(Default)]
struct Impatient {
    trainings: AtomicUsize,
    cancel: AtomicBool,
}

impl Progress for Impatient {}

impl Observer for Impatient {
    fn event(&self, event: Event<'_>) {
        if matches!(event, Event::TrainingBegins(..)) {
            let is_second = self.trainings.fetch_add(1, Ordering::Relaxed) == 1;
            self.cancel.store(is_second, Ordering::Relaxed);
        }
    }
}

#[test]
fn an_interrupted_benchmark_goes_on_from_there() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("bench");
    let mut config = Profile::Smoke.config();
    config.models = vec![ModelKind::PolarReg, ModelKind::ResnetMlp];
    let bench = Benchmark::new(config, &out).unwrap();
    let impatient = Impatient::default();
    let watch = Watch {
        observer: &impatient,
        cancel: &impatient.cancel,
    };
    let ended = bench.run(watch).unwrap_err();
    assert!(matches!(ended, Error::Interrupted(_)), "{ended:?}");
    let again = Impatient::default();
    let watch = Watch {
        observer: &again,
        ..Watch::default()
    };
    let results = bench.run(watch).unwrap();
    assert!(results.failed.is_empty(), "{:?}", results.failed);
    // The first model was finished, the second is continued.
    assert_eq!(again.trainings.into_inner(), 1);
    for name in ["Polar-Reg", "ResNet-MLP"] {
        assert_eq!(
            entry(&results, name).training.as_ref().unwrap().curve.len(),
            2
        );
    }
}
