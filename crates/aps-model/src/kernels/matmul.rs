//! Calls the matrix product of [`gemm`].

/// A matrix laid over a slice: element (i, j) is `data[i * row_stride + j * col_stride]`.
#[derive(Clone, Copy)]
pub(crate) struct Matrix<'a> {
    pub data: &'a [f32],
    pub row_stride: usize,
    pub col_stride: usize,
}

impl<'a> Matrix<'a> {
    /// Rows that begin `stride` values apart, each without gaps.
    pub fn rows(data: &'a [f32], stride: usize) -> Self {
        Self {
            data,
            row_stride: stride,
            col_stride: 1,
        }
    }

    /// Columns that begin `stride` values apart, each without gaps.
    pub fn columns(data: &'a [f32], stride: usize) -> Self {
        Self::rows(data, stride).transposed()
    }

    /// Rows as columns.
    pub fn transposed(self) -> Self {
        Self {
            data: self.data,
            row_stride: self.col_stride,
            col_stride: self.row_stride,
        }
    }
}

/// `out (+)= a * b` on this thread, for `a` of rows x depth, `b` of depth x cols and `out` with columns of `out_stride`
/// values, each column without gaps.
///
/// # Panics
/// If a matrix does not fit into its slice.
pub(crate) fn multiply(
    sizes: (usize, usize, usize),
    a: Matrix<'_>,
    b: Matrix<'_>,
    out: &mut [f32],
    out_stride: usize,
    accumulate: bool,
) {
    let one = gemm::Parallelism::None;
    product(sizes, a, b, out, out_stride, accumulate, one);
}

/// [`multiply`] by all threads of this pool; each value of `out` is still summed by one of them, in the same order.
pub(crate) fn multiply_on_all_threads(
    sizes: (usize, usize, usize),
    a: Matrix<'_>,
    b: Matrix<'_>,
    out: &mut [f32],
    out_stride: usize,
    accumulate: bool,
) {
    let all = gemm::Parallelism::Rayon(rayon::current_num_threads());
    product(sizes, a, b, out, out_stride, accumulate, all);
}

#[allow(unsafe_code)]
fn product(
    (rows, cols, depth): (usize, usize, usize),
    a: Matrix<'_>,
    b: Matrix<'_>,
    out: &mut [f32],
    out_stride: usize,
    accumulate: bool,
    parallelism: gemm::Parallelism,
) {
    let fits = |len: usize, r: usize, c: usize, rs: usize, cs: usize| {
        let last = |r: usize, c: usize| r.checked_mul(rs)?.checked_add(c.checked_mul(cs)?);
        r == 0 || c == 0 || last(r - 1, c - 1).is_some_and(|last| last < len)
    };
    assert!(fits(a.data.len(), rows, depth, a.row_stride, a.col_stride));
    assert!(fits(b.data.len(), depth, cols, b.row_stride, b.col_stride));
    assert!(fits(out.len(), rows, cols, 1, out_stride));
    assert!(cols <= 1 || out_stride >= rows, "columns overlap");
    // SAFETY: the assertions above keep every element of the three matrices inside its slice, and `out`, borrowed
    // mutably, cannot overlap the others. All strides are those of slices, hence below isize::MAX.
    unsafe {
        gemm::gemm(
            rows,
            cols,
            depth,
            out.as_mut_ptr(),
            out_stride as isize,
            1,
            accumulate,
            a.data.as_ptr(),
            a.col_stride as isize,
            a.row_stride as isize,
            b.data.as_ptr(),
            b.col_stride as isize,
            b.row_stride as isize,
            1.0,
            1.0,
            false,
            false,
            false,
            parallelism,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn product_of_transposed_and_plain() {
        // a = [[1, 2, 3], [4, 5, 6]] stored by columns, b = [[1], [10], [100]].
        let a = Matrix::columns(&[1.0, 4.0, 2.0, 5.0, 3.0, 6.0], 2);
        let b = Matrix::columns(&[1.0, 10.0, 100.0], 3);
        let mut out = [1.0, 1.0];
        multiply((2, 1, 3), a, b, &mut out, 2, true);
        assert_eq!(out, [322.0, 655.0]);
        multiply((2, 1, 3), a, b, &mut out, 2, false);
        assert_eq!(out, [321.0, 654.0]);
    }

    #[test]
    #[should_panic]
    fn matrix_beyond_its_slice() {
        let a = Matrix::columns(&[1.0; 3], 2);
        multiply((2, 2, 2), a, a, &mut [0.0; 4], 2, false);
    }
}
