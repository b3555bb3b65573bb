//! The figures of the paper's Tables I to III, to be read beside one's own.
//!
//! They hold for its data (2.55 million links of a commercial ray tracer, 249,993 of them scored),
//! its training (20 epochs on a GPU from pretrained backbones) and its hardware. A run on other data
//! or of another size is not expected to reproduce the numbers; what can be asked of it is whether
//! the same things come first.

use aps_metrics::Metric;

/// A row of the paper's tables.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Published {
    /// Name in the tables, which entries share.
    pub name: &'static str,
    /// Columns MAE, PSNR, CosSim, NMSE, Angle, PLE, Hit@2, Hit@4, Rec.@2, Rec.@4; NaN if not given.
    columns: [f64; 10],
}

const NONE: f64 = f64::NAN;

/// Rows of the tables, the rows of Table I first.
pub const PUBLISHED: [Published; 7] = [
    Published {
        name: "MS-AReg",
        columns: [
            0.099, 37.23, 0.948, -20.03, 10.08, 1.20, 0.524, 0.541, 0.934, 0.951,
        ],
    },
    Published {
        name: "RadioUNet",
        columns: [
            0.182, 34.11, 0.861, -16.91, 19.10, 1.30, 0.538, 0.558, 0.865, 0.893,
        ],
    },
    Published {
        name: "ResNet-MLP",
        columns: [
            0.193, 31.51, 0.851, -14.31, 21.06, 1.69, 0.453, 0.474, 0.860, 0.890,
        ],
    },
    Published {
        name: "ViT-Reg",
        columns: [
            0.216, 33.70, 0.804, -16.50, 24.00, 2.06, 0.481, 0.501, 0.817, 0.847,
        ],
    },
    Published {
        name: "ResNet-Conv1D",
        columns: [
            0.224, 31.36, 0.802, -14.16, 25.18, 2.29, 0.457, 0.478, 0.818, 0.851,
        ],
    },
    Published {
        name: "MS-MLP",
        columns: [
            NONE, 29.48, 0.870, -12.28, NONE, 1.31, 0.435, 0.457, 0.880, 0.913,
        ],
    },
    Published {
        name: "Adv-MLP",
        columns: [
            NONE, 37.68, 0.853, -20.48, NONE, 1.84, 0.532, 0.546, 0.859, 0.882,
        ],
    },
];

/// The row of a name.
pub fn published(name: &str) -> Option<&'static Published> {
    PUBLISHED.iter().find(|row| row.name == name)
}

impl Published {
    /// The paper's figure for a metric.
    pub fn of(&self, metric: Metric) -> Option<f64> {
        let column = Metric::PAPER_COLUMNS.iter().position(|&m| m == metric)?;
        Some(self.columns[column]).filter(|v| v.is_finite())
    }
}
