//! State of a link: it has a label, or the reason why it has none.

use std::fmt;

/// The state of a link: stored as one byte, counted in the manifest by name.
///
/// Every code but 0 means that the link has no label. Codes of later versions of the format are
/// kept as [`LinkStatus::Other`], so that an old reader still tells labelled links from others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum LinkStatus {
    /// Code 0: the link has a label.
    Valid,
    /// Code 1: no path connects the two ends.
    NoPath,
    /// Code 2: the transmitter is inside a building.
    TxInBuilding,
    /// Code 3: the receiver is inside a building.
    RxInBuilding,
    /// Code 4: an end lies outside the map.
    OutsideArea,
    /// Code 5: transmitter and receiver are at the same point.
    SamePoint,
    /// Code 6: an end lies exactly on a wall.
    OnWall,
    /// Code 7: there are paths, but none that the label's protocol keeps.
    Unlabelled,
    /// Code 8: one end is in a courtyard closed on all sides and the other is not in it.
    Enclosed,
    /// A code this version does not know. With a code that it knows, it is stored and named as that state.
    Other(u8),
}

impl LinkStatus {
    /// The states with a code of their own, in the order of their codes.
    pub const KNOWN: [LinkStatus; 9] = [
        LinkStatus::Valid,
        LinkStatus::NoPath,
        LinkStatus::TxInBuilding,
        LinkStatus::RxInBuilding,
        LinkStatus::OutsideArea,
        LinkStatus::SamePoint,
        LinkStatus::OnWall,
        LinkStatus::Unlabelled,
        LinkStatus::Enclosed,
    ];

    /// Returns the byte stored in `status.npy`.
    pub fn code(self) -> u8 {
        match self {
            LinkStatus::Valid => 0,
            LinkStatus::NoPath => 1,
            LinkStatus::TxInBuilding => 2,
            LinkStatus::RxInBuilding => 3,
            LinkStatus::OutsideArea => 4,
            LinkStatus::SamePoint => 5,
            LinkStatus::OnWall => 6,
            LinkStatus::Unlabelled => 7,
            LinkStatus::Enclosed => 8,
            LinkStatus::Other(code) => code,
        }
    }

    /// Returns the state with the given code.
    pub fn from_code(code: u8) -> Self {
        Self::KNOWN
            .get(usize::from(code))
            .copied()
            .unwrap_or(LinkStatus::Other(code))
    }

    /// Returns true when the link has a label.
    pub fn is_valid(self) -> bool {
        self.code() == 0
    }
}

/// The name under which the manifest counts the state, e.g. `no_path`.
impl fmt::Display for LinkStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const NAMES: [&str; LinkStatus::KNOWN.len()] = [
            "valid",
            "no_path",
            "tx_in_building",
            "rx_in_building",
            "outside_area",
            "same_point",
            "on_wall",
            "unlabelled",
            "enclosed",
        ];
        match NAMES.get(usize::from(self.code())) {
            Some(name) => f.write_str(name),
            None => write!(f, "code_{}", self.code()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_their_own_inverse() {
        for code in 0..=255 {
            assert_eq!(LinkStatus::from_code(code).code(), code);
        }
        for (code, status) in LinkStatus::KNOWN.into_iter().enumerate() {
            assert_eq!(usize::from(status.code()), code);
        }
    }

    #[test]
    fn a_state_is_named_as_it_is_stored() {
        let valid = LinkStatus::Other(0);
        assert_eq!((valid.is_valid(), &*valid.to_string()), (true, "valid"));
        assert_eq!(LinkStatus::Other(4).to_string(), "outside_area");
        assert_eq!(LinkStatus::Other(99).to_string(), "code_99");
    }
}
