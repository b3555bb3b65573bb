//! Errors of exports and imports.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use aps_data::released::LinkName;

/// Fault of an export or an import.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExchangeError {
    /// Labels of another protocol than the published data's.
    #[error(
        "the labels follow the protocol {}, the published data `released`; make or import the data set with that \
         protocol, or relabel its paths",
        .0.as_ref().map_or("of nobody knows what".into(), |name| format!("`{name}`"))
    )]
    Protocol(Option<String>),
    /// A folder with another export.
    #[error("'{}' is of another export; give another folder", .0.display())]
    OtherExport(PathBuf),
    /// A folder with files of a map that has left the part of the split that is exported.
    #[error(
        "'{}' has files of map {map}, which is of another part now that the data set has grown; give another folder",
        folder.display()
    )]
    LeftPart {
        /// The map.
        map: u32,
        /// The folder.
        folder: PathBuf,
    },
    /// A folder with files of others.
    #[error("'{}' holds other files; give an empty folder, or one that is not there yet", .0.display())]
    NotEmpty(PathBuf),
    /// A file whose name does not tell its link, or one of another map.
    #[error(
        "'{}' does not tell its link by its name, or is of another map: names are MAP_TXX_TXY_RXX_RXY in whole metres; rename it, or move it \
         away",
        .0.display()
    )]
    Unnamed(PathBuf),
    /// A link whose places make no file name.
    #[error("map {map}, link {link} from {tx_m:?} to {rx_m:?} m: too far away for a name")]
    TooFar {
        /// The map.
        map: u32,
        /// Row of the link.
        link: usize,
        /// Place of the transmitter \[m\].
        tx_m: [f64; 2],
        /// Place of the receiver \[m\].
        rx_m: [f64; 2],
    },
    /// Two links whose files would have the same name.
    #[error(
        "map {map}, link {link}: another link has the same places in whole metres, so the same file name {name}"
    )]
    SameName {
        /// The map.
        map: u32,
        /// Row of the second link.
        link: usize,
        /// The name.
        name: LinkName,
    },
    /// A data set that does not tell the places of maxima.
    #[error("the data set has neither paths nor the delays of its maxima")]
    NoPlaces,
    /// Images of another scale than the published samples'.
    #[error(
        "a pixel is {0} m; samples have images of 1 m a pixel: make the data set of tiles of 256 m, or export another \
         layout"
    )]
    PixelSize(f64),
    /// A stored label that its paths do not make.
    #[error("it is stored with a label, but its paths make none; verify the data set")]
    NoLabel,
    /// An export that was not finished.
    #[error("the export into '{}' was not finished; start it again to finish it, then import it", .0.display())]
    Unfinished(PathBuf),
    /// A folder without files to import.
    #[error("nothing to import in '{}': expected {expected}", folder.display())]
    Nothing {
        /// The folder.
        folder: PathBuf,
        /// Names of the files.
        expected: &'static str,
    },
    /// Two files of one transmitter.
    #[error(
        "'{}' and '{}' are the same transmitter of the same map; import one of them",
        .0[0].display(), .0[1].display()
    )]
    SameTransmitter([PathBuf; 2]),
    /// Two files of one link.
    #[error("'{}' and '{}' are the same link; import one of them", .0[0].display(), .0[1].display())]
    SameLink([PathBuf; 2]),
    /// A folder of a map whose number is too large.
    #[error("'{}': maps have numbers up to {}; rename it", .0.display(), u32::MAX)]
    MapNumber(PathBuf),
    /// A value that no label has.
    #[error(
        "bin {bin}: its {column} is {value}, expected {} to {}; the first column is power, in dB relative to isotropic antennas or 1 mW, \
         the second the place of its maximum",
        expected.start(), expected.end()
    )]
    Impossible {
        /// The bin.
        bin: usize,
        /// The value.
        value: f64,
        /// Quantity of the column, with its unit.
        column: &'static str,
        /// Values that are possible.
        expected: RangeInclusive<f64>,
    },
    /// A sample whose spectrum is not normalised.
    #[error(
        "aps_norm has the mean {mean:.3} and the deviation {deviation:.3}, expected 0 and 1: it is power relative to the maximum, minus \
         its mean, divided by its deviation, or brought to -1 up to 1"
    )]
    NotNormalised {
        /// Mean of the spectrum.
        mean: f64,
        /// Its population deviation.
        deviation: f64,
    },
    /// A condition image whose spot is not where the name of the sample says.
    #[error(
        "by its name the {end} is at {place_m:?} m, but its plane of cond_img is brightest at column {}, row {}: a pixel is a metre, rows \
         are y, and the planes are buildings, transmitter, receiver",
        brightest[0], brightest[1]
    )]
    Spot {
        /// `transmitter` or `receiver`.
        end: &'static str,
        /// Its place by the name \[m\].
        place_m: [i32; 2],
        /// Column and row of a pixel that is at least as bright.
        brightest: [usize; 2],
    },
    /// Labelled links that end inside buildings.
    #[error(
        "{count} of {links} links have a label, but end inside a building of the map '{}', the first from {tx_m:?} to {rx_m:?} m with its {end}: \
         the map is not the one that the labels were made on; give the maps of the labels, or none",
        map.display()
    )]
    InBuilding {
        /// Number of such links.
        count: usize,
        /// Links of the map.
        links: usize,
        /// Place of the first one's transmitter \[m\].
        tx_m: [f64; 2],
        /// Place of its receiver \[m\].
        rx_m: [f64; 2],
        /// Its end inside a building, `transmitter` or `receiver`.
        end: &'static str,
        /// The file of the map.
        map: PathBuf,
    },
    /// More receivers asked for than there are.
    #[error("it has only {found} receivers, {asked} were asked for")]
    Receivers {
        /// Receivers of the map.
        found: usize,
        /// Receivers asked for.
        asked: usize,
    },
    /// A spectrum of another length.
    #[error("{found} bins, expected {expected}")]
    Bins {
        /// Bins of the file.
        found: usize,
        /// Bins of the first file, or of the format.
        expected: usize,
    },
    /// A condition image of another size.
    #[error("its image is {found:?} pixels, the first one's {expected:?}")]
    ImageSize {
        /// Height and width.
        found: [usize; 2],
        /// Height and width of the first image.
        expected: [usize; 2],
    },
    /// An image of buildings with other values than 0 and 1.
    #[error("a pixel of its buildings is neither 0 nor 1")]
    Pixel,
    /// A table that cannot be written.
    #[cfg(feature = "parquet")]
    #[error("the table cannot be written")]
    Parquet(#[source] parquet::errors::ParquetError),
    /// A map whose number the tables have no room for.
    #[cfg(feature = "parquet")]
    #[error("map {0}: the tables have room for numbers up to {max}; give the map a smaller one", max = i32::MAX)]
    NoRoomForMap(u32),
    /// A sample of another map.
    #[error("its buildings are not those of the map's first sample")]
    OtherBuildings,
}
