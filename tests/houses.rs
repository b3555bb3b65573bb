//! Small maps, for tests of all kinds.

/// Three houses and a thin wall, elsewhere on each map.
pub fn map(id: u32) -> String {
    let shift = 7 * id;
    let house = |x: u32, y: u32, w: u32, h: u32| {
        let (x, y) = (x + shift, y + shift);
        format!(
            "[[{x},{y}],[{},{y}],[{},{}],[{x},{}],[{x},{y}]]",
            x + w,
            x + w,
            y + h,
            y + h
        )
    };
    let houses = [
        house(40, 60, 30, 20),
        house(90, 30, 15, 60),
        house(60, 120, 50, 12),
        house(20, 110, 2, 40),
    ];
    format!("[{}]", houses.join(","))
}
