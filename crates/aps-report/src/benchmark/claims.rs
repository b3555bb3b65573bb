//! Findings of the paper, asked again of these results: a verdict each, and the comparisons behind them.

use aps_metrics::Metric;

use super::analysis::{Analysis, Verdict as Sign};
use super::paper::published;
use super::results::EntryKind;
use super::words;
use crate::document::{Table, Verdict};
use crate::numbers::list;

/// The model that the paper proposes.
const OURS: &str = "MS-AReg";

/// A finding: one entry is better than another in some metrics, for some pairs.
struct Claim {
    text: &'static str,
    pairs: Vec<(&'static str, String)>,
    metrics: &'static [Metric],
}

/// The findings; the first is of all other models that were run.
fn claims(analysis: &Analysis<'_>) -> [Claim; 3] {
    let models = analysis.of_kinds(&[EntryKind::Model]);
    let others = models.iter().filter(|m| m.name != OURS);
    let pairs = |pairs: [(&'static str, &str); 2]| pairs.map(|(a, b)| (a, b.to_owned())).to_vec();
    [
        Claim {
            text: "MS-AReg is first of the models in CosSim and Recall",
            pairs: others.map(|m| (OURS, m.name.clone())).collect(),
            metrics: &[Metric::Cosine, Metric::Recall2Deg, Metric::Recall4Deg],
        },
        Claim {
            text: "Multi-scale encoding helps localisation (PLE, Recall)",
            pairs: pairs([("MS-MLP", "ResNet-MLP"), (OURS, "Adv-MLP")]),
            metrics: &[Metric::PleDeg, Metric::Recall2Deg, Metric::Recall4Deg],
        },
        Claim {
            text: "The training-only regularizer helps amplitude (PSNR, NMSE)",
            pairs: pairs([("Adv-MLP", "ResNet-MLP"), (OURS, "MS-MLP")]),
            metrics: &[Metric::PsnrDb, Metric::NmseDb],
        },
    ]
}

/// A verdict on each finding, and a table of all comparisons behind them: the difference is above 0 if the first is
/// better, whichever way the metric runs.
pub fn claims_of_the_paper(analysis: &Analysis<'_>, protocol: &str) -> (Vec<Verdict>, Table) {
    let head = [
        "finding",
        "comparison",
        "metric",
        "better by",
        "95 % interval",
        "paper",
        "it is",
    ];
    let caption = format!("Comparisons behind the verdicts, link by link, protocol {protocol}");
    let mut table = Table::new(caption, head);
    let mut verdicts = Vec::new();
    for (number, claim) in (1..).zip(claims(analysis)) {
        let mut signs = Vec::new();
        let mut missing: Vec<&str> = Vec::new();
        for (with, without) in &claim.pairs {
            let (Some(a), Some(b)) = (analysis.entry(with), analysis.entry(without)) else {
                let names = [*with, without].into_iter();
                missing.extend(names.filter(|name| analysis.entry(name).is_none()));
                continue;
            };
            for &metric in claim.metrics {
                let Some(gain) = analysis.gain(a, b, protocol, metric) else {
                    continue;
                };
                signs.push(gain.verdict());
                let paper = |name: &str| published(name)?.of(metric);
                let paper = paper(with).zip(paper(without)).map(|(a, b)| {
                    format!(
                        "{} against {}",
                        words::value(metric, a),
                        words::value(metric, b)
                    )
                });
                table.push([
                    number.to_string(),
                    format!("{with} against {without}"),
                    words::axis(metric),
                    words::value(metric, gain.estimate.mean),
                    words::interval(metric, &gain.estimate),
                    paper.unwrap_or_default(),
                    gain.verdict().word().into(),
                ]);
            }
        }
        missing.sort_unstable();
        missing.dedup();
        verdicts.push(verdict(
            format!("{number}. {}", claim.text),
            &signs,
            &missing,
        ));
    }
    (verdicts, table)
}

/// Judges a claim: passed if every comparison goes the way of the claim beyond its interval, failed if one goes the other way.
fn verdict(claim: String, signs: &[Sign], missing: &[&str]) -> Verdict {
    let count = |sign: Sign| signs.iter().filter(|&&s| s == sign).count();
    let (better, worse) = (count(Sign::Better), count(Sign::Worse));
    if !missing.is_empty() || signs.is_empty() {
        let missing = match missing {
            [] => &["anything to compare with"],
            missing => missing,
        };
        return Verdict::open(claim, format!("not tested, no scores of {}", list(missing)));
    }
    let evidence = format!(
        "{better} of {} comparisons better, {worse} worse",
        signs.len()
    );
    match better == signs.len() || worse > 0 {
        true => Verdict::decided(worse == 0, claim, evidence),
        false => Verdict::open(claim, evidence),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Outcome;

    #[test]
    fn answers_follow_from_the_comparisons() {
        use Sign::{Better, Undecided, Worse};
        let outcome = |signs: &[Sign]| verdict(String::new(), signs, &[]).outcome;
        assert_eq!(outcome(&[Better, Better]), Outcome::Pass);
        assert_eq!(outcome(&[Better, Undecided]), Outcome::Open);
        assert_eq!(outcome(&[Better, Worse]), Outcome::Fail);
        assert_eq!(outcome(&[Undecided, Worse]), Outcome::Fail);
        assert_eq!(outcome(&[Undecided, Undecided]), Outcome::Open);
        assert_eq!(
            verdict(String::new(), &[Better], &["a"]).outcome,
            Outcome::Open
        );
    }
}
