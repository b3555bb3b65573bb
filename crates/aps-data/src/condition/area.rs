//! Images brought to another size by averaging.

/// A map of `sides` rows and columns as a `size` x `size` one: each pixel the average over the area it covers.
pub fn average(map: &[f32], sides: [usize; 2], size: usize) -> Vec<f32> {
    let [rows, columns] = sides.map(|side| shares(side, size));
    let mut image = Vec::with_capacity(size * size);
    for (first_row, row_shares) in &rows {
        for (first_column, column_shares) in &columns {
            let mut sum = 0.0;
            for (y, share) in (*first_row..).zip(row_shares) {
                let row = &map[y * sides[1] + first_column..][..column_shares.len()];
                let pixels = row.iter().zip(column_shares);
                sum += share * pixels.map(|(&v, w)| f64::from(v) * w).sum::<f64>();
            }
            image.push((sum as f32).clamp(0.0, 1.0));
        }
    }
    image
}

/// For each new pixel, the first old one it covers, and the shares of it that this and the following ones take. In units of
/// 1 / (side * size) of the whole, all ends are whole numbers.
fn shares(side: usize, size: usize) -> Vec<(usize, Vec<f64>)> {
    let of_pixel = |pixel: usize| {
        let (start, end) = (pixel * side, (pixel + 1) * side);
        let (first, last) = (start / size, (end - 1) / size);
        let share = |old: usize| {
            let overlap = end.min((old + 1) * size) - start.max(old * size);
            overlap as f64 / side as f64
        };
        (first, (first..=last).map(share).collect())
    };
    (0..size).map(of_pixel).collect()
}
