//! Settings laid over each other: a profile, a file, single ones.

use std::path::Path;

use toml::{Table, Value};

use super::{Config, Profile};
use crate::error::{Error, Result};

impl Config {
    /// The settings of a profile, changed by those that a file names, changed by `flags`. A flag of `training` is for all models: it
    /// replaces what the profile or the file says of single ones.
    ///
    /// # Errors
    /// A file that cannot be read, a key that is not known, a value of another type or out of range; it is named.
    pub fn resolve(profile: Profile, file: Option<&Path>, flags: Table) -> Result<Self> {
        let mut table = profile.table();
        if let Some(path) = file {
            let text = std::fs::read_to_string(path);
            let text = text.map_err(Error::file("configuration", path))?;
            let own = text.parse::<Table>().map_err(|e| in_one_line(&e));
            change(&mut table, own.map_err(Error::file("configuration", path))?);
            Config::of(table.clone()).map_err(Error::file("configuration", path))?;
        }
        if let Some(Value::Table(training)) = flags.get("training")
            && let Some(Value::Table(models)) = table.get_mut("model")
        {
            for model in models.iter_mut().filter_map(|(_, m)| m.as_table_mut()) {
                model.retain(|key, _| !training.contains_key(key));
            }
        }
        change(&mut table, flags);
        Config::of(table)
    }

    /// Adds a setting to flags, by its keys from the outermost on.
    ///
    /// # Errors
    /// A setting that is given twice, or as a value and as a table; it is named.
    pub fn flag(flags: &mut Table, keys: &[&str], value: Value) -> Result<()> {
        let twice = || Error::Setting(format!("{} is given twice; give it once", keys.join(".")));
        let (last, tables) = keys.split_last().expect("a setting has a name");
        let mut table = flags;
        for &key in tables {
            let inner = table.entry(key).or_insert(Value::Table(Table::new()));
            table = inner.as_table_mut().ok_or_else(twice)?;
        }
        match table.insert((*last).into(), value) {
            Some(_) => Err(twice()),
            None => Ok(()),
        }
    }

    /// The settings of a table that is whole.
    pub(super) fn of(table: Table) -> Result<Self> {
        let config: Config = table.try_into().map_err(|e| in_one_line(&e))?;
        config.check()?;
        Ok(config)
    }
}

/// Replaces values of `table` by those of `other`, table by table. Budget and epochs both end a training: one of them in `other`
/// replaces both in `table`.
fn change(table: &mut Table, other: Table) {
    if let (Some(Value::Table(own)), Some(Value::Table(new))) =
        (table.get_mut("training"), other.get("training"))
    {
        for [given, replaced] in [["epochs", "budget"], ["budget", "epochs"]] {
            if new.contains_key(given) {
                own.remove(replaced);
            }
        }
    }
    merge(table, other);
}

fn merge(table: &mut Table, other: Table) {
    for (key, value) in other {
        match (table.get_mut(&key), value) {
            (Some(Value::Table(inner)), Value::Table(other)) => merge(inner, other),
            (_, value) => {
                table.insert(key, value);
            }
        }
    }
}

/// TOML's messages show the place over several lines; those of errors have one.
fn in_one_line(error: &toml::de::Error) -> Error {
    Error::Setting(error.to_string().trim().replace('\n', " "))
}

#[cfg(test)]
mod tests {
    use aps_model::ModelKind;
    use map2aps::error::chain;

    use super::*;

    fn with_file(text: &str, flags: &str) -> Result<Config> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bench.toml");
        std::fs::write(&path, text).unwrap();
        Config::resolve(Profile::Quick, Some(&path), flags.parse().unwrap())
    }

    #[test]
    fn flag_overrides_file_and_file_overrides_profile() {
        let file =
            "seed = 7\n[training]\nbatch = 9\n[model.ms_areg]\nbatch = 11\nlearning_rate = 0.5";
        let config = with_file(file, "").unwrap();
        let batch = |config: &Config, kind| config.training(kind).unwrap().batch;
        assert_eq!(config.seed, 7);
        assert_eq!(batch(&config, ModelKind::MsAreg), 11);
        assert_eq!(config.profile_name(Profile::Quick), "custom");
        let config = with_file(file, "training.batch = 1").unwrap();
        assert!(ModelKind::ALL.iter().all(|&kind| batch(&config, kind) == 1));
        let areg = config.training(ModelKind::MsAreg).unwrap();
        assert_eq!(areg.learning_rate, 0.5);
    }

    #[test]
    fn flags_that_are_given_twice_are_refused() {
        let given = |all: &[&[&str]]| {
            let mut flags = Table::new();
            let mut all = all.iter();
            all.try_for_each(|keys| Config::flag(&mut flags, keys, Value::from("x")))
        };
        given(&[&["external", "a"], &["external", "b"], &["models"]]).unwrap();
        for (flags, told) in [
            (
                [["external", "a"], ["external", "a"]]
                    .each_ref()
                    .map(|k| &k[..]),
                "external.a is given twice",
            ),
            ([&["models", "x"][..], &["models"]], "models is given twice"),
            (
                [&["models"], &["models", "x"][..]],
                "models.x is given twice",
            ),
        ] {
            let error = chain(&given(&flags).unwrap_err());
            assert!(error.contains(told), "{error}");
        }
    }

    #[test]
    fn of_budget_and_epochs_the_later_ends_a_training() {
        let ends = |file: &str, flags: &str| {
            let config = with_file(file, flags).unwrap();
            let training = config.training(ModelKind::MsMlp).unwrap();
            (training.budget_s, training.epochs)
        };
        assert_eq!(ends("[training]\nepochs = 3", ""), (None, 3));
        let minutes = "training.budget = '10m'";
        assert_eq!(ends("[training]\nepochs = 3", minutes), (Some(600.0), 20));
        let both = with_file("[training]\nepochs = 3\nbudget = '1h'", "").unwrap_err();
        assert!(chain(&both).contains("give one"), "{both:?}");
    }

    #[test]
    fn unknown_keys_are_named() {
        for (text, key) in [
            ("sead = 1", "sead"),
            ("[training]\nepoch = 1", "epoch"),
            ("[model.ms_areg]\nlr = 1.0", "lr"),
            ("[model.alexnet]\nbatch = 1", "alexnet"),
            ("models = ['lenet']", "lenet"),
        ] {
            let error = chain(&with_file(text, "").unwrap_err());
            assert!(
                error.contains(key) && error.contains("bench.toml"),
                "{error}"
            );
            assert!(!error.contains('\n'), "{error}");
        }
    }

    #[test]
    fn values_out_of_range_are_named() {
        for (text, key) in [
            ("[data]\ntest_maps = 0", "data.test_maps"),
            ("[latency]\nbatches = []", "latency.batches"),
            ("[latency]\nseconds = nan", "latency.seconds"),
            ("[training]\nbudget = 'soon'", "training.budget"),
            ("[training]\nbudget = '0s'", "training.budget"),
            ("seed = 'x'", "seed"),
        ] {
            let error = chain(&with_file(text, "").unwrap_err());
            assert!(error.contains(key), "{error}");
        }
    }
}
