//! Faults found in footprints, and their repairs.

use std::fmt;

/// One finding. Buildings and vertices count from 0 in the footprints as given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Repair {
    /// The building.
    pub building: usize,
    /// Kind of the finding, with its repair.
    pub kind: RepairKind,
}

/// Kinds of findings, each with the repair it leads to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum RepairKind {
    /// A ring turned the wrong way and was reversed.
    Reoriented,
    /// A vertex repeats its predecessor (an edge of length zero); it was removed.
    DuplicateVertex {
        /// The vertex.
        vertex: usize,
    },
    /// A vertex lies on the line through its neighbours and was removed; where the outline runs
    /// back on itself this cuts off the spike.
    CollinearVertex {
        /// The vertex.
        vertex: usize,
    },
    /// Two edges of the building cross or touch; the outline was rebuilt around all it encloses.
    SelfIntersection {
        /// Start of one edge.
        vertex: usize,
    },
    /// The area is below the limit; the ring was dropped.
    Sliver,
    /// The building overlaps another; walls inside the union were removed.
    Overlaps {
        /// The other building.
        other: usize,
    },
    /// The building touches another; shared walls were removed.
    Touches {
        /// The other building.
        other: usize,
    },
    /// Another building is just as large as a courtyard of this one and fills it.
    CourtyardFilled {
        /// The other building.
        by: usize,
    },
    /// A hole surrounds the outer ring; the two changed places.
    RingsReordered,
    /// A slit narrower than [`SceneConfig::close_gaps_m`](super::SceneConfig::close_gaps_m) between walls of this building
    /// and another, or of its own; it was filled.
    Gap {
        /// The building on the other side.
        other: usize,
    },
}

impl RepairKind {
    /// Names of one finding of this kind and of several. A report lists them in the order of the variants.
    fn names(&self) -> [&'static str; 2] {
        match self {
            Self::Reoriented => ["reoriented"; 2],
            Self::DuplicateVertex { .. } => ["duplicate vertex", "duplicate vertices"],
            Self::CollinearVertex { .. } => ["collinear vertex", "collinear vertices"],
            Self::SelfIntersection { .. } => ["self-intersection", "self-intersections"],
            Self::Sliver => ["sliver dropped", "slivers dropped"],
            Self::Overlaps { .. } => ["overlapping pair", "overlapping pairs"],
            Self::Touches { .. } => ["touching pair", "touching pairs"],
            Self::CourtyardFilled { .. } => [
                "courtyard filled by a building",
                "courtyards filled by a building",
            ],
            Self::RingsReordered => [
                "hole taken for an outer ring",
                "holes taken for outer rings",
            ],
            Self::Gap { .. } => ["gap closed", "gaps closed"],
        }
    }
}

/// Findings of one scene, in the order of the buildings.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RepairReport {
    /// The findings.
    pub repairs: Vec<Repair>,
}

impl RepairReport {
    /// Returns true when the footprints were used as they came.
    #[must_use]
    pub fn is_clean(&self) -> bool {
        self.repairs.is_empty()
    }

    /// Counts the findings that a predicate selects.
    #[must_use]
    pub fn count(&self, select: impl Fn(&RepairKind) -> bool) -> usize {
        self.repairs.iter().filter(|r| select(&r.kind)).count()
    }

    pub(crate) fn push(&mut self, building: usize, kind: RepairKind) {
        self.repairs.push(Repair { building, kind });
    }
}

/// One line: how often each kind was found, or "clean".
impl fmt::Display for RepairReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_clean() {
            return f.write_str("clean");
        }
        let mut kinds: Vec<RepairKind> = self.repairs.iter().map(|r| r.kind).collect();
        kinds.sort_unstable();
        let same_kind = kinds.chunk_by(|p, q| p.names() == q.names());
        let counts: Vec<String> = same_kind
            .map(|kinds| {
                let [one, many] = kinds[0].names();
                format!(
                    "{} {}",
                    kinds.len(),
                    if kinds.len() == 1 { one } else { many }
                )
            })
            .collect();
        f.write_str(&counts.join(", "))
    }
}
