//! Numbers of things in messages.

use std::fmt::Display;

/// A number with the name of what it counts: `1 map`, `3 maps`, `0 maps`.
///
/// ```
/// assert_eq!(map2aps::counted(1, "map", "maps"), "1 map");
/// assert_eq!(map2aps::counted(20_u64, "map", "maps"), "20 maps");
/// ```
pub fn counted<N: Display + PartialEq + From<u8>>(count: N, one: &str, many: &str) -> String {
    let name = if count == N::from(1) { one } else { many };
    format!("{count} {name}")
}
