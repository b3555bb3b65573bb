//! Errors of reading a city.

use thiserror::Error;

/// Error of reading a city. Features count from 0, through all collections of a file.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum GeoJsonError {
    /// The text is not GeoJSON.
    #[error("not valid GeoJSON: {reason}")]
    Syntax {
        /// Description of the fault, with line and column or feature where they are known.
        reason: String,
    },
    /// The text holds no feature at all.
    #[error("there is no feature in it")]
    NoFeature,
    /// No feature has the tag.
    #[error(
        "none of {features} features has a `building` tag; export OpenStreetMap's buildings, or take every polygon for one"
    )]
    NoTag {
        /// Features in the file.
        features: usize,
    },
    /// No feature is a building with an area.
    #[error("none of {features} features is a building with an area")]
    NoBuilding {
        /// Features in the file.
        features: usize,
    },
    /// A position without two numbers.
    #[error("feature {feature}: a position needs two numbers")]
    Position {
        /// Index of the feature.
        feature: usize,
    },
    /// A reference system that is not read.
    #[error(
        "its `crs` is {crs}, which is not read (degrees of WGS 84, EPSG:3857 and UTM are); convert it: ogr2ogr -t_srs EPSG:4326 NEW.geojson OLD.geojson"
    )]
    Crs {
        /// Name of the system in the member, or the member's text if it has none.
        crs: String,
    },
    /// A reference system that is said to be unknown, by `"crs": null`.
    #[error(
        "its `crs` is null: nothing says what its numbers are; if they are longitude and latitude, remove the member"
    )]
    UnknownCrs,
    /// Features of several reference systems.
    #[error("feature {feature} is in {crs}, those before it in {first}; write the file in one")]
    MixedCrs {
        /// Index of the first feature that differs.
        feature: usize,
        /// Reference system of the building.
        crs: String,
        /// Reference system of the features before it.
        first: String,
    },
    /// Metres asked for, and a reference system whose numbers are none.
    #[error("its `crs` says {crs}, whose numbers are not metres on the ground")]
    NotMetres {
        /// The reference system.
        crs: String,
    },
    /// A coordinate that cannot be.
    #[error("feature {feature}: ({x}, {y}) is no {expected}")]
    Coordinate {
        /// Index of the feature.
        feature: usize,
        /// First coordinate.
        x: f64,
        /// Second coordinate.
        y: f64,
        /// Description of a valid position.
        expected: String,
    },
    /// A second coordinate that can only be a longitude, if it is an angle at all.
    #[error(
        "feature {feature}: ({x}, {y}): {y} is no latitude; GeoJSON has longitude first: are they swapped?"
    )]
    Latitude {
        /// Index of the feature.
        feature: usize,
        /// First coordinate.
        x: f64,
        /// Second coordinate.
        y: f64,
    },
    /// A building at a pole, where no plane has an east.
    #[error("feature {feature} is within {limit_deg} degree of a pole")]
    Pole {
        /// Index of the feature.
        feature: usize,
        /// Smallest distance from a pole that is read \[deg\].
        limit_deg: f64,
    },
    /// The buildings are too far apart for one plane.
    #[error(
        "feature {feature}: ({x}, {y}) is {distance_deg:.1} degrees from the origin, the middle of all buildings unless another is given; at most {limit_deg} fit one plane; cut the file, unless its numbers are metres"
    )]
    TooLarge {
        /// Index of the feature.
        feature: usize,
        /// First coordinate.
        x: f64,
        /// Second coordinate.
        y: f64,
        /// Distance from the origin of the plane \[deg\].
        distance_deg: f64,
        /// Largest distance that fits one plane \[deg\].
        limit_deg: f64,
    },
    /// The origin asked for is no place in the unit of the file.
    #[error("origin ({}, {}): no place in the unit of the file's numbers", .0[0], .0[1])]
    Origin([f64; 2]),
    /// No building is as large as a metre.
    #[error(
        "the largest of {buildings} buildings is {size_m:.3} m long: the numbers must be in another unit"
    )]
    TooSmall {
        /// Buildings in the file.
        buildings: usize,
        /// Longest side of a bounding box \[m\].
        size_m: f64,
    },
}
