//! Errors of the settings in a manifest.

/// Fault of the settings in a manifest.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SettingsError {
    /// Settings that are not there.
    #[error("its manifest has no {0} settings")]
    None(&'static str),
    /// Settings that this version does not know.
    #[error("its manifest has unknown {name} settings")]
    Unknown {
        /// Name of the settings.
        name: &'static str,
        /// Fault of the JSON.
        source: serde_json::Error,
    },
    /// A data set without paths.
    #[error("it stores no paths to be labelled")]
    NoPaths,
    /// Neither kind of label is to be stored.
    #[error(
        "neither spectra nor delay profiles are to be stored: there is nothing else to make anew"
    )]
    NothingToLabel,
    /// Links are to be computed anew, and the maps are not given.
    #[error("links can be computed anew only from the maps of the data set")]
    NoMaps,
    /// Links are to be computed anew, and the data set was not traced.
    #[error(
        "links can be computed anew only in a data set that was traced here; this one was imported"
    )]
    NotTraced,
    /// A material that this version does not know.
    #[error("its manifest names the unknown material '{0}'")]
    Material(String),
    /// A setting of earlier versions that this one does not repeat.
    #[error("it was traced with --accuracy {0}, which is gone: its links cannot be computed anew")]
    Accuracy(f64),
}
