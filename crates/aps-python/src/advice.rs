//! Arguments that help against an error of the library, which does not know them.

use map2aps::aps_raytrace::scene::GeoJsonError;
use map2aps::settings::SettingsError;
use map2aps::{Error, MapError, ScoreError};

/// Text to put behind the error with this cause; empty where no argument helps.
pub fn advice(cause: &Error) -> &'static str {
    match cause {
        Error::GeoJson(error) => geojson(error),
        Error::Map(MapError::NoScene(_)) => " (maps=...)",
        Error::Mirror(_) => "; mirror=False leaves the mirror images out",
        Error::Settings(SettingsError::NoPaths) => "; make one that does with store_paths=True",
        Error::Score(ScoreError::NoTrainingLabel | ScoreError::FlatLabels) => {
            " (domain=\"linear\" needs no statistics)"
        }
        _ => "",
    }
}

/// Argument to add or leave away where a file was read in another way than its writer meant.
fn geojson(error: &GeoJsonError) -> &'static str {
    match error {
        GeoJsonError::NoTag { .. } => " (all_polygons=True takes untagged ones)",
        GeoJsonError::Coordinate { .. }
        | GeoJsonError::Latitude { .. }
        | GeoJsonError::TooLarge { .. }
        | GeoJsonError::UnknownCrs => " (metric=True takes its numbers for metres)",
        GeoJsonError::NotMetres { .. } => "; leave metric=True away",
        _ => "",
    }
}
