//! What the paper found, asked again of these results, and what the baselines say of the models.

use aps_metrics::Metric;

use super::analysis::{Analysis, Gain, HEADLINE, Verdict};
use super::paper::published;
use super::results::{Entry, EntryKind};
use super::words;

/// One of the paper's findings, and whether it shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// What the paper found.
    pub claim: &'static str,
    /// Whether it shows here.
    pub answer: Answer,
    /// The comparisons behind the answer.
    pub evidence: Vec<String>,
}

/// Whether a finding shows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Answer {
    /// Every comparison goes its way, beyond the interval.
    Shows,
    /// Some do, with the number of those that do and of all.
    Partly(usize, usize),
    /// None does, and at least one goes the other way.
    DoesNotShow,
    /// All intervals hold 0.
    Open,
    /// What is missing for it.
    NotTested(Vec<String>),
}

impl Answer {
    fn of(verdicts: &[Verdict]) -> Self {
        let count = |v: Verdict| verdicts.iter().filter(|&&found| found == v).count();
        match (count(Verdict::Better), count(Verdict::Worse)) {
            (better, _) if better == verdicts.len() => Self::Shows,
            (0, 0) => Self::Open,
            (0, _) => Self::DoesNotShow,
            (better, _) => Self::Partly(better, verdicts.len()),
        }
    }

    /// The answer in words.
    pub fn in_words(&self) -> String {
        match self {
            Self::Shows => "shows here".into(),
            Self::Partly(some, all) => format!("shows here in part ({some} of {all} comparisons)"),
            Self::DoesNotShow => "does not show here".into(),
            Self::Open => "can neither be seen nor ruled out here".into(),
            Self::NotTested(missing) => {
                format!("was not tested: no scores of {}", words::list(missing))
            }
        }
    }
}

/// The three findings, under one protocol.
pub fn findings(analysis: &Analysis<'_>, protocol: &str) -> Vec<Finding> {
    vec![
        leads(analysis, protocol),
        ablation(
            analysis,
            protocol,
            "Multi-scale encoding helps localisation (PLE, Recall)",
            [("MS-MLP", "ResNet-MLP"), ("MS-AReg", "Adv-MLP")],
            &[Metric::PleDeg, Metric::Recall2Deg, Metric::Recall4Deg],
        ),
        ablation(
            analysis,
            protocol,
            "The training-only regularizer helps amplitude (PSNR, NMSE)",
            [("Adv-MLP", "ResNet-MLP"), ("MS-AReg", "MS-MLP")],
            &[Metric::PsnrDb, Metric::NmseDb],
        ),
    ]
}

fn leads(analysis: &Analysis<'_>, protocol: &str) -> Finding {
    const OURS: &str = "MS-AReg";
    let claim = "MS-AReg is first of the models in CosSim and Recall";
    let models = analysis.of_kinds(&[EntryKind::Model]);
    let others: Vec<&Entry> = models.iter().copied().filter(|m| m.name != OURS).collect();
    let (Some(ours), false) = (analysis.entry(OURS), others.is_empty()) else {
        let missing = match analysis.entry(OURS) {
            None => OURS.to_owned(),
            Some(_) => "any other model".to_owned(),
        };
        return not_tested(claim, vec![missing]);
    };
    let mut verdicts = Vec::new();
    let mut evidence = Vec::new();
    for metric in [Metric::Cosine, Metric::Recall2Deg, Metric::Recall4Deg] {
        let gains: Vec<Verdict> = others
            .iter()
            .filter_map(|other| analysis.gain(ours, other, protocol, metric))
            .map(|gain| gain.verdict())
            .collect();
        let Some(best) = analysis.best(&others, protocol, metric) else {
            continue;
        };
        let (Some(mine), Some(gain)) = (
            analysis.mean(ours, protocol, metric),
            analysis.gain(ours, best, protocol, metric),
        ) else {
            continue;
        };
        // First means ahead of all: the least favourable comparison decides.
        verdicts.extend(gains.iter().max());
        evidence.push(format!(
            "{}: {OURS} has {}; {}, the best of the other models, has {}: {OURS} is {}.",
            metric.label(),
            words::value(metric, mine.mean),
            best.name,
            words::value(metric, mine.mean - signed(metric, gain.estimate.mean)),
            words::gain(metric, &gain),
        ));
    }
    conclude(claim, &verdicts, evidence, protocol)
}

fn ablation(
    analysis: &Analysis<'_>,
    protocol: &str,
    claim: &'static str,
    pairs: [(&str, &str); 2],
    metrics: &[Metric],
) -> Finding {
    let mut missing: Vec<String> = Vec::new();
    for name in pairs.iter().flat_map(|p| [p.0, p.1]) {
        if analysis.entry(name).is_none() {
            missing.push(name.into());
        }
    }
    if !missing.is_empty() {
        return not_tested(claim, missing);
    }
    let mut verdicts = Vec::new();
    let mut evidence = Vec::new();
    for (with, without) in pairs {
        for &metric in metrics {
            let (Some(a), Some(b)) = (analysis.entry(with), analysis.entry(without)) else {
                continue;
            };
            let Some(gain) = analysis.gain(a, b, protocol, metric) else {
                continue;
            };
            verdicts.push(gain.verdict());
            let paper = |name: &str| published(name)?.of(metric);
            let beside = match (paper(with), paper(without)) {
                (Some(a), Some(b)) => format!(
                    " (paper: {} against {})",
                    words::value(metric, a),
                    words::value(metric, b)
                ),
                _ => String::new(),
            };
            evidence.push(format!(
                "{}, {with} against {without}: {}{beside}.",
                metric.label(),
                words::gain(metric, &gain),
            ));
        }
    }
    conclude(claim, &verdicts, evidence, protocol)
}

fn conclude(
    claim: &'static str,
    verdicts: &[Verdict],
    evidence: Vec<String>,
    protocol: &str,
) -> Finding {
    if verdicts.is_empty() {
        return not_tested(claim, vec![format!("protocol {protocol}")]);
    }
    Finding {
        claim,
        answer: Answer::of(verdicts),
        evidence,
    }
}

fn not_tested(claim: &'static str, missing: Vec<String>) -> Finding {
    Finding {
        claim,
        answer: Answer::NotTested(missing),
        evidence: Vec::new(),
    }
}

/// A gain as a difference of the metric itself.
fn signed(metric: Metric, gain: f64) -> f64 {
    match metric.better() {
        aps_metrics::Better::Higher => gain,
        aps_metrics::Better::Lower => -gain,
    }
}

/// What the baselines that know nothing of the map say of each learned model, one sentence a model.
pub fn against_baselines(analysis: &Analysis<'_>, protocol: &str) -> Vec<String> {
    let baselines = analysis.of_kinds(&[EntryKind::Baseline]);
    let judge = |model: &&Entry| {
        let mut fails = Vec::new();
        let mut compared = 0;
        for baseline in &baselines {
            for metric in HEADLINE {
                let Some(gain) = analysis.gain(model, baseline, protocol, metric) else {
                    continue;
                };
                compared += 1;
                if gain.verdict() != Verdict::Better {
                    let how = words::gain(metric, &gain);
                    fails.push(format!("{} in {} ({how})", baseline.name, metric.label()));
                }
            }
        }
        let names: Vec<&str> = HEADLINE.iter().map(|m| m.label()).collect();
        let against: Vec<&str> = baselines.iter().map(|b| b.name.as_str()).collect();
        match (compared, fails.is_empty()) {
            (0, _) => None,
            (_, true) => Some(format!(
                "{} beats {} in {}.",
                model.name,
                words::list(&against),
                words::list(&names)
            )),
            (_, false) => Some(format!(
                "{} does not beat {}.",
                model.name,
                fails.join("; nor ")
            )),
        }
    };
    analysis.learned().iter().filter_map(judge).collect()
}

/// What the tracer with lower limits says of the models: one sentence a setting.
pub fn against_tracer(analysis: &Analysis<'_>, protocol: &str) -> Vec<String> {
    let models = analysis.learned();
    let say = |tracer: &&Entry| {
        // Who is ahead, and in which metrics it is the same ones.
        let mut parts: Vec<(Vec<&str>, Vec<&str>)> = Vec::new();
        for metric in HEADLINE {
            let gains: Vec<(&str, Gain)> = models
                .iter()
                .filter_map(|m| {
                    Some((m.name.as_str(), analysis.gain(m, tracer, protocol, metric)?))
                })
                .collect();
            if gains.is_empty() {
                continue;
            }
            let is_ahead = |(_, gain): &&(&str, Gain)| gain.verdict() == Verdict::Better;
            let ahead: Vec<&str> = gains.iter().filter(is_ahead).map(|g| g.0).collect();
            match parts.iter_mut().find(|part| part.0 == ahead) {
                Some(part) => part.1.push(metric.label()),
                None => parts.push((ahead, vec![metric.label()])),
            }
        }
        let part = |(ahead, metrics): &(Vec<&str>, Vec<&str>)| {
            let who = match ahead.len() {
                0 => "no model".into(),
                n if n == models.len() => "every model".into(),
                _ => words::list(ahead),
            };
            format!("in {} by {who}", words::list(metrics))
        };
        let parts: Vec<String> = parts.iter().map(part).collect();
        (!parts.is_empty()).then(|| format!("{} is beaten {}.", tracer.name, parts.join("; ")))
    };
    let tracers = analysis.of_kinds(&[EntryKind::Tracer]);
    tracers.iter().filter_map(say).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_follow_from_the_verdicts() {
        use Verdict::{Better, Undecided, Worse};
        assert_eq!(Answer::of(&[Better, Better]), Answer::Shows);
        assert_eq!(Answer::of(&[Better, Undecided]), Answer::Partly(1, 2));
        assert_eq!(Answer::of(&[Better, Worse]), Answer::Partly(1, 2));
        assert_eq!(Answer::of(&[Undecided, Worse]), Answer::DoesNotShow);
        assert_eq!(Answer::of(&[Undecided, Undecided]), Answer::Open);
    }
}
