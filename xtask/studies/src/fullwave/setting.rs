//! Settings of the tracer that are compared.

use aps_raytrace::TraceConfig;

/// The settings that are named in tables: places in [`Setting::all`].
pub const R2_D1: usize = 0;
pub const CASCADE: usize = 1;
pub const SLOPES: usize = 2;
pub const FAR_CASCADE: usize = 3;
pub const FAR: usize = 4;

/// A setting of the tracer.
#[derive(Debug, Clone)]
pub struct Setting {
    pub name: String,
    pub config: TraceConfig,
}

impl Setting {
    fn new(r: usize, d: usize, range_db: f64, slope_diffraction: bool) -> Self {
        let slopes = if slope_diffraction { ", slopes" } else { "" };
        Self {
            name: format!("R{r} D{d}, {range_db} dB{slopes}"),
            config: TraceConfig {
                dynamic_range_db: Some(range_db),
                slope_diffraction,
                ..TraceConfig::within(r, d)
            },
        }
    }

    /// Makes the settings, those first that tables name.
    pub fn all() -> Vec<Self> {
        let mut all = vec![
            Self::new(2, 1, 60.0, false),
            Self::new(5, 2, 30.0, false),
            Self::new(5, 2, 30.0, true),
            Self::new(8, 3, 40.0, false),
            Self::new(8, 3, 40.0, true),
        ];
        for (r, d, range_db) in [
            (0, 1, 60.0),
            (1, 1, 60.0),
            (3, 1, 60.0),
            (5, 1, 60.0),
            (8, 1, 60.0),
            (2, 2, 30.0),
            (5, 2, 20.0),
            (5, 2, 40.0),
            (8, 2, 30.0),
            (5, 3, 30.0),
        ] {
            all.push(Self::new(r, d, range_db, false));
            if d > 1 {
                all.push(Self::new(r, d, range_db, true));
            }
        }
        all
    }

    /// Limits beyond those of [`Self::all`], without and with slopes.
    pub fn beyond() -> impl Iterator<Item = Self> {
        let limits = [(12, 3), (16, 3), (24, 3), (8, 4), (12, 4), (16, 4)];
        let both = |(r, d)| [false, true].map(|slopes| Self::new(r, d, 40.0, slopes));
        limits.into_iter().flat_map(both)
    }
}
