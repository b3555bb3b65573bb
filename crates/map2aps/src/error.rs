//! The errors of this crate: what went wrong, wrapped in where it did.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use aps_data::released::LinkName;

use crate::dataset::MergeError;
use crate::exchange::ExchangeError;
use crate::maps::MapError;
use crate::mirror::MirrorError;
use crate::path_list::PathListError;
use crate::scores::ScoreError;
use crate::settings::SettingsError;

/// Result of a function of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// An error of this crate or of one that it builds on.
///
/// The message of an error does not repeat its cause, which is its source: print the whole chain. Places wrap causes,
/// the widest outside; [`Error::cause`] looks behind them.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The place of an error.
    #[error("{place}")]
    At {
        /// The place.
        place: Place,
        /// The error there.
        source: Box<Error>,
    },
    /// The operation was cancelled.
    #[error("interrupted")]
    Cancelled,
    /// The making of a data set was cancelled.
    #[error("interrupted; {kept} whole maps are kept in '{}', the same command continues", folder.display())]
    Interrupted {
        /// Whole maps in the folder.
        kept: usize,
        /// Folder of the data set.
        folder: PathBuf,
    },
    /// The making of a data set failed.
    #[error(
        "stopped; {kept} whole maps are kept in '{}', with the cause removed the same command continues",
        folder.display()
    )]
    Stopped {
        /// Whole maps in the folder.
        kept: usize,
        /// Folder of the data set.
        folder: PathBuf,
        /// Cause of the failure.
        source: Box<Error>,
    },
    /// The operating system refused something.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// Values that JSON cannot hold.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    /// A map or the choice of maps.
    #[error(transparent)]
    Map(#[from] MapError),
    /// Settings in a manifest.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// A path list in JSON.
    #[error(transparent)]
    PathList(#[from] PathListError),
    /// Files of the published data.
    #[error(transparent)]
    Exchange(#[from] ExchangeError),
    /// Shards that cannot be joined.
    #[error(transparent)]
    Merge(#[from] MergeError),
    /// Predictions or labels that cannot be scored.
    #[error(transparent)]
    Score(#[from] ScoreError),
    /// Spectra of mirrored maps.
    #[error(transparent)]
    Mirror(#[from] MirrorError),
    /// A data set on disk.
    #[error(transparent)]
    Data(#[from] aps_data::Error),
    /// A `.npy` file.
    #[error(transparent)]
    Npy(#[from] aps_data::npy::NpyError),
    /// The image of a map.
    #[error(transparent)]
    Raster(#[from] aps_data::RasterError),
    /// A `.npz` sample.
    #[error(transparent)]
    Sample(#[from] aps_data::released::SampleError),
    /// A `.propbin` file.
    #[error(transparent)]
    Propbin(#[from] aps_data::propbin::PropbinError),
    /// Settings of labels.
    #[error(transparent)]
    LabelConfig(#[from] aps_label::ConfigError),
    /// Paths that cannot be labelled.
    #[error(transparent)]
    Paths(#[from] aps_label::PathError),
    /// Spectra that cannot be normalised.
    #[error(transparent)]
    Normalization(#[from] aps_label::NormalizationError),
    /// The geometry of a link.
    #[error(transparent)]
    Polar(#[from] aps_raytrace::polar::PolarError),
    /// Limits of the tracer.
    #[error(transparent)]
    TraceConfig(#[from] aps_raytrace::ConfigError),
    /// Footprints that make no scene.
    #[error(transparent)]
    Scene(#[from] aps_raytrace::SceneError),
    /// A terminal that cannot stand where it is.
    #[error(transparent)]
    Terminal(#[from] aps_raytrace::TerminalError),
    /// A link that cannot be traced.
    #[error(transparent)]
    Trace(#[from] aps_raytrace::TraceError),
    /// A city in GeoJSON.
    #[cfg(feature = "geojson")]
    #[error(transparent)]
    GeoJson(#[from] aps_raytrace::scene::GeoJsonError),
    /// A city that cannot be cut into maps.
    #[error(transparent)]
    Tiling(#[from] aps_raytrace::scene::TilingError),
    /// Spectra that cannot be compared.
    #[error(transparent)]
    Metrics(#[from] aps_metrics::Error),
    /// A training, or weights that were trained.
    #[cfg(feature = "models")]
    #[error(transparent)]
    Training(#[from] crate::training::TrainingError),
    /// A model, its weights or its input.
    #[cfg(feature = "models")]
    #[error(transparent)]
    Model(#[from] aps_model::Error),
    /// A step of a training, or a prediction.
    #[cfg(feature = "models")]
    #[error(transparent)]
    Train(#[from] aps_model::train::TrainError),
}

#[cfg(feature = "models")]
impl From<aps_model::candle_core::Error> for Error {
    fn from(error: aps_model::candle_core::Error) -> Self {
        Self::Model(error.into())
    }
}

impl Error {
    /// The error behind all places.
    pub fn cause(&self) -> &Error {
        match self {
            Self::At { source, .. } | Self::Stopped { source, .. } => source.cause(),
            error => error,
        }
    }

    /// Returns true when the operation ended because it was cancelled.
    pub fn is_cancelled(&self) -> bool {
        match self.cause() {
            Self::Cancelled | Self::Interrupted { .. } => true,
            #[cfg(feature = "models")]
            Self::Training(crate::training::TrainingError::Interrupted { .. }) => true,
            _ => false,
        }
    }

    /// The error with its causes in one line. A cause that ends the text so far is left out: some libraries repeat it.
    pub fn chain(&self) -> String {
        chain(self)
    }
}

/// An error with its causes in one line, as [`Error::chain`].
pub fn chain(error: &(dyn std::error::Error + 'static)) -> String {
    let mut text = error.to_string();
    let causes = std::iter::successors(error.source(), |cause| cause.source());
    for cause in causes.map(ToString::to_string) {
        if !text.ends_with(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text
}

/// Place of an error.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Place {
    /// A file.
    File(PathBuf),
    /// A file or folder that was to be read.
    Reading(PathBuf),
    /// A file that was to be written.
    Writing(PathBuf),
    /// A folder that was to be created.
    Creating(PathBuf),
    /// A file that was to be removed.
    Removing(PathBuf),
    /// A data set.
    Dataset(PathBuf),
    /// The file of a map.
    MapFile(PathBuf),
    /// A folder of maps.
    MapFolder(PathBuf),
    /// The file of a city.
    City(PathBuf),
    /// The folder that a map of a data set was to be taken from.
    MapFrom(u32, PathBuf),
    /// A map of a data set.
    Map(u32),
    /// A map of the data set that labels are made anew of.
    SourceMap(u32),
    /// A map of the maps that a data set is compared with.
    GivenMap(u32),
    /// A tile of a city.
    Tile(u32),
    /// A link, by its row in the map.
    Link(usize),
    /// A path, by its place in a link.
    Path(usize),
    /// A link, by the name of its files.
    LinkName(LinkName),
    /// The transmitter of a link.
    Transmitter,
    /// A transmitter, by its row among those given.
    TransmitterRow(usize),
    /// A receiver, by its row in the map or its number in a file.
    Receiver(i64),
    /// Spectra that are compared, described.
    Comparison(String),
    /// A log of a training.
    Log(PathBuf),
    /// A file of weights.
    Weights(PathBuf),
    /// A file of weights, and the model that they are read for.
    WeightsOf(PathBuf, String),
    /// Initial weights, described.
    InitialWeights(String),
    /// Notes that a training keeps in its checkpoint.
    CheckpointNotes,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(path) => write!(f, "'{}'", path.display()),
            Self::Reading(path) => write!(f, "cannot read '{}'", path.display()),
            Self::Writing(path) => write!(f, "cannot write '{}'", path.display()),
            Self::Creating(path) => write!(f, "cannot create '{}'", path.display()),
            Self::Removing(path) => write!(f, "cannot remove '{}'", path.display()),
            Self::Dataset(path) => write!(f, "data set '{}'", path.display()),
            Self::MapFile(path) => write!(f, "map '{}'", path.display()),
            Self::MapFolder(path) => write!(
                f,
                "cannot read the maps in '{}' (give a folder of files 0.json, 1.json, ..., a GeoJSON file, or synthetic:N)",
                path.display()
            ),
            Self::City(path) => write!(f, "city '{}'", path.display()),
            Self::MapFrom(id, path) => write!(f, "cannot take map {id} from '{}'", path.display()),
            Self::Map(id) => write!(f, "map {id}"),
            Self::SourceMap(id) => write!(f, "map {id} of the source"),
            Self::GivenMap(id) => write!(f, "map {id} of the maps given"),
            Self::Tile(id) => write!(f, "tile {id}"),
            Self::Link(row) => write!(f, "link {row}"),
            Self::Path(place) => write!(f, "path {place}"),
            Self::LinkName(name) => write!(f, "link {name}"),
            Self::Transmitter => write!(f, "transmitter"),
            Self::TransmitterRow(row) => write!(f, "transmitter {row}"),
            Self::Receiver(id) => write!(f, "receiver {id}"),
            Self::Comparison(what) => write!(f, "{what}"),
            Self::Log(path) => write!(f, "log '{}'", path.display()),
            Self::Weights(path) => write!(f, "weights '{}'", path.display()),
            Self::WeightsOf(path, model) => {
                write!(f, "'{}' as weights of {model}", path.display())
            }
            Self::InitialWeights(what) => write!(f, "initial weights: {what}"),
            Self::CheckpointNotes => write!(f, "notes of the checkpoint"),
        }
    }
}

/// Refuses what is no file: a folder, or a pipe, which has no length.
pub(crate) fn must_be_file(path: &Path) -> io::Result<()> {
    let kind = std::fs::metadata(path)?.file_type();
    match (kind.is_file(), kind.is_dir()) {
        (true, _) => Ok(()),
        (_, true) => Err(io::Error::other("it is a folder, not a file")),
        _ => Err(io::Error::other(
            "it is a pipe or a device, not a file; copy what it gives into one",
        )),
    }
}

/// Adds the place to an error.
pub(crate) trait At<T> {
    fn at(self, place: Place) -> Result<T>;
    fn at_file(self, place: fn(PathBuf) -> Place, path: &Path) -> Result<T>;
}

impl<T, E: Into<Error>> At<T> for Result<T, E> {
    fn at(self, place: Place) -> Result<T> {
        self.map_err(|error| Error::At {
            place,
            source: Box::new(error.into()),
        })
    }

    fn at_file(self, place: fn(PathBuf) -> Place, path: &Path) -> Result<T> {
        self.map_err(|error| Error::At {
            place: place(path.into()),
            source: Box::new(error.into()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Error that repeats its cause, as those of zip and csv do.
    #[derive(Debug, thiserror::Error)]
    #[error("i/o error: {0}")]
    struct Repeats(#[from] io::Error);

    #[test]
    fn what_is_no_file_is_told_as_what_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let told = |path: &Path| must_be_file(path).unwrap_err().to_string();
        assert!(told(folder.path()).contains("a folder"));
        assert!(told(&folder.path().join("none")).starts_with("No such file"));
        #[cfg(unix)]
        assert!(told(Path::new("/dev/null")).contains("a device"));
    }

    #[test]
    fn causes_are_told_once() {
        let repeated = Repeats(io::Error::other("the disk is full"));
        assert_eq!(chain(&repeated), "i/o error: the disk is full");
        let error = Err::<(), _>(MapError::NoArea)
            .at(Place::Map(3))
            .unwrap_err();
        let no_area = "the map has no area to draw terminals from";
        assert_eq!(error.chain(), format!("map 3: {no_area}"));
        assert_eq!(error.to_string(), "map 3");
    }
}
