//! Progress of a benchmark, and the time that is left.

use std::time::{Duration, Instant};
use xtask::note;

use aps_model::{ModelKind, Preset};

use super::config::Config;

/// Progress over stages whose times are guessed beforehand and corrected by those that have ended.
pub struct Pace {
    /// Guesses \[s\], stage by stage.
    guesses: Vec<f64>,
    ended: usize,
    /// Guessed and measured time of the stages that were not reused \[s\].
    guessed: f64,
    measured: f64,
    started: Instant,
}

impl Pace {
    /// Begins, with a guess of the time of each stage \[s\].
    pub fn new(guesses: Vec<f64>) -> Self {
        Self {
            guesses,
            ended: 0,
            guessed: 0.0,
            measured: 0.0,
            started: Instant::now(),
        }
    }

    /// Announces the next stage.
    pub fn announce(&self, what: &str) {
        let whole = |seconds: f64| {
            humantime::format_duration(Duration::from_secs(seconds.ceil() as u64)).to_string()
        };
        note!(
            "[{}/{}] {what} ({} so far, about {} left)",
            self.ended + 1,
            self.guesses.len(),
            whole(self.started.elapsed().as_secs_f64()),
            whole(self.left())
        );
    }

    /// Ends a stage that took this long \[s\]; none if it was reused.
    pub fn end(&mut self, measured: Option<f64>) {
        if let Some(measured) = measured {
            self.guessed += self.guesses.get(self.ended).copied().unwrap_or(0.0);
            self.measured += measured;
        }
        self.ended += 1;
    }

    /// Time left \[s\].
    fn left(&self) -> f64 {
        let guess: f64 = self.guesses.iter().skip(self.ended).sum();
        let correction = match self.guessed > 0.0 {
            true => self.measured / self.guessed,
            false => 1.0,
        };
        guess * correction
    }
}

/// Guess of the time to make the data \[s\]: about 0.3 ms a link.
pub fn data_s(links: usize) -> f64 {
    1.0 + 3e-4 * links as f64
}

/// Guess of the time to train, score and time a model \[s\], from how its cost grows with pixels, width and kind.
pub fn model_s(config: &Config, kind: ModelKind, train_links: usize, test_links: usize) -> f64 {
    // Relative to resnet_mlp, a step of training; a regularizer adds two networks of its own.
    let relative = match kind {
        ModelKind::AdvMlp | ModelKind::MsAreg => 3.0,
        ModelKind::ResnetConv1d => 2.0,
        ModelKind::RadioUnet => 6.0,
        // It works on images of 224 pixels, whatever it is given.
        ModelKind::VitReg => 12.0,
        _ => 1.0,
    };
    let width = match config.preset() {
        Ok(Preset::Paper) => 4.0,
        _ => 1.0,
    };
    let pixels = (config.image_size(kind) as f64 / 64.0).powi(2);
    let step_s = 4e-3 * relative * width * pixels;
    let epochs = config.model(kind).epochs.unwrap_or(config.training.epochs);
    let links = config
        .links(kind)
        .map_or(train_links, |links| links.min(train_links));
    let batches = config.latency.batches.len() as f64;
    step_s * (epochs as f64 * links as f64 + 0.3 * test_links as f64)
        + batches * config.latency.seconds
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_left_follows_the_stages_that_ended() {
        let mut pace = Pace::new(vec![10.0, 10.0, 20.0]);
        assert_eq!(pace.left(), 40.0);
        pace.end(Some(5.0));
        assert_eq!(pace.left(), 15.0);
        pace.end(None);
        assert_eq!(pace.left(), 10.0);
        pace.end(Some(10.0));
        assert_eq!(pace.left(), 0.0);
    }
}
