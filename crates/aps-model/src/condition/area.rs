//! Images brought to another size by averaging.

/// A map of `sides` rows and columns as a `size` x `size` one: each pixel the average over the area it covers. The size
/// it has already leaves it as it is.
pub fn average(map: &[f32], sides: [usize; 2], size: usize) -> Vec<f32> {
    if sides == [size, size] {
        return map.to_vec();
    }
    let [rows, columns] = sides.map(|side| weights(side, size));
    let mut image = Vec::with_capacity(size * size);
    for (first_row, row_weights) in &rows {
        for (first_column, column_weights) in &columns {
            let mut sum = 0.0;
            for (y, wy) in (*first_row..).zip(row_weights) {
                let row = &map[y * sides[1] + first_column..][..column_weights.len()];
                let pairs = row.iter().zip(column_weights);
                sum += wy * pairs.map(|(&v, w)| f64::from(v) * w).sum::<f64>();
            }
            image.push((sum as f32).clamp(0.0, 1.0));
        }
    }
    image
}

/// Computes, for each new pixel, the first old one it covers, and the shares of it that this and the following ones take.
///
/// In units of 1 / (side * size) of the whole, all ends are whole numbers.
fn weights(side: usize, size: usize) -> Vec<(usize, Vec<f64>)> {
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

#[cfg(test)]
mod tests {
    use super::average;

    #[test]
    fn halves_average_pairs() {
        let map = [0.0, 1.0, 1.0, 1.0, /**/ 0.0, 0.0, 1.0, 0.0];
        assert_eq!(average(&map, [2, 4], 2), [0.5, 1.0, 0.0, 0.5]);
        assert_eq!(average(&map, [2, 4], 1), [0.5]);
    }

    #[test]
    fn fraction_of_a_pixel_counts_by_its_share() {
        // Three columns onto two: [a, b/2], [b/2, c].
        let image = average(&[1.0, 1.0, 0.0].repeat(3), [3, 3], 2);
        assert!((image[0] - 1.0).abs() < 1e-7 && (image[1] - 1.0 / 3.0).abs() < 1e-7);
    }

    #[test]
    fn larger_image_repeats_pixels() {
        assert_eq!(average(&[0.25], [1, 1], 2), [0.25; 4]);
    }
}
