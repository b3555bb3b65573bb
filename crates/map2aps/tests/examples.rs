//! The examples run, and none of them is longer than the documentation says.

#[path = "../examples/make_dataset.rs"]
mod make_dataset;
#[path = "../examples/score_predictions.rs"]
mod score;
#[cfg(feature = "models")]
#[path = "../examples/train_and_score.rs"]
mod train_and_score;

/// Lines of the body of `main`.
fn lines(source: &str) -> usize {
    let body = source.split("fn main()").nth(1).unwrap();
    body.lines().skip(1).take_while(|line| *line != "}").count()
}

#[test]
fn a_data_set_is_made_a_prediction_scored_and_a_model_trained_in_15_lines_each() {
    for source in [
        include_str!("../examples/make_dataset.rs"),
        include_str!("../examples/score_predictions.rs"),
        include_str!("../examples/train_and_score.rs"),
    ] {
        assert!(lines(source) <= 15, "{} lines", lines(source));
    }
    let folder = tempfile::tempdir().unwrap();
    std::env::set_current_dir(folder.path()).unwrap();
    make_dataset::main().unwrap();
    score::main().unwrap();
    #[cfg(feature = "models")]
    train_and_score::main().unwrap();
}
