//! Options of the command line that help against an error of the library, which does not know them.

use anyhow::Error;
use aps_raytrace::scene::GeoJsonError;
use aps_raytrace::{ConfigError, TerminalError};
use map2aps::{
    Error as Cause, ExchangeError, MapError, MergeError, MissingPart, ScoreError, SettingsError,
};

use crate::args;
use crate::command_line;

/// Text to put behind the error; empty where no option helps.
pub fn advice(error: &Error) -> String {
    let Some(cause) = error
        .chain()
        .find_map(|cause| cause.downcast_ref::<Cause>())
    else {
        return String::new();
    };
    match cause.cause() {
        Cause::GeoJson(error) => geojson(error),
        Cause::Map(MapError::NotGeoJson { .. }) => " in --map-ids",
        Cause::Map(MapError::NoImage(_)) => " (cargo xtask import ... --maps)",
        Cause::Map(MapError::NoPart { .. }) => {
            "; name another part (--split, or --part of an export)"
        }
        Cause::Exchange(ExchangeError::Protocol { .. }) => {
            " (--protocol released), or give --any-protocol"
        }
        Cause::Exchange(ExchangeError::NoPlaces) => {
            "; make it with --store aps,paths, or give --zero-places"
        }
        Cause::Data(aps_data::Error::NotStored { .. }) => " (--store aps,pdp,paths)",
        Cause::Score(ScoreError::NoTrainingLabel | ScoreError::FlatLabels) => {
            " (metrics --domain linear needs no statistics)"
        }
        Cause::TraceConfig(ConfigError::Corner(_) | ConfigError::TooManyWaves { .. })
        | Cause::Terminal(TerminalError::TooManyImages { .. } | TerminalError::TooManyWaves { .. }) => {
            " (no option raises these: take --limits r2d1, lower --max-reflections or --max-diffractions, or cut a city into smaller maps by --tile)"
        }
        Cause::Settings(SettingsError::NoPaths) => {
            "; make one that does with cargo xtask dataset --store aps,paths --out DIR"
        }
        Cause::Settings(SettingsError::NothingToLabel) => "; name aps, pdp or both with --store",
        Cause::Settings(SettingsError::NotTraced) => "; use --sample 0",
        Cause::Merge(MergeError::Missing { folders, parts, .. }) => {
            let made: Vec<String> = parts.iter().map(command).collect();
            let new = parts.iter().map(|part| &part.folder);
            let new = new.filter(|folder| !folders.contains(folder));
            let new = new.map(|folder| folder.display().to_string());
            let merge = command_line::own_without(&[]).into_iter().chain(new);
            return format!(
                ":\n  {}\nand then join them:\n  {}",
                made.join("\n  "),
                command_line::shown(merge)
            );
        }
        _ => "",
    }
    .into()
}

/// Option to add or leave away where a file was read in another way than its writer meant.
fn geojson(error: &GeoJsonError) -> &'static str {
    match error {
        GeoJsonError::NoTag { .. } => " (--all-polygons takes untagged ones)",
        GeoJsonError::Coordinate { .. }
        | GeoJsonError::Latitude { .. }
        | GeoJsonError::TooLarge { .. }
        | GeoJsonError::UnknownCrs => " (--metric takes its numbers for metres)",
        GeoJsonError::NotMetres { .. } => "; leave --metric away",
        _ => "",
    }
}

/// The command that makes a missing part of a data set.
fn command(part: &MissingPart) -> String {
    let mut words = part.command.clone();
    if let Some(shard) = args::shard(part.shard) {
        words.extend(["--shard".into(), shard]);
    }
    words.extend(["--out".into(), part.folder.display().to_string()]);
    command_line::shown(words)
}
