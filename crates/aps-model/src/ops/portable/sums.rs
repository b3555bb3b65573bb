//! Sums of values that say where they belong.

use candle_core::{CustomOp1, Result, Tensor};

use super::computed::{Computed, forward};

/// Adds each of the values (rows, values) to the column that `columns`, of the same shape, names in its row: (rows, `count`).
///
/// candle 0.11 has no gradient of its `scatter_add` where a row has another number of values than of columns. That of its `index_add`
/// over the columns of all rows is right, but on a GPU one thread adds all values one after another; here there is one a row.
pub(crate) fn add_to_columns(values: &Tensor, columns: &Tensor, count: usize) -> Result<Tensor> {
    let zeros = Tensor::zeros((values.dim(0)?, count), values.dtype(), values.device())?;
    let result = zeros.scatter_add(columns, &values.detach().contiguous()?, 1)?;
    values.apply_op1(ColumnSums {
        columns: columns.clone(),
        result: Computed::new(result),
    })
}

struct ColumnSums {
    columns: Tensor,
    result: Computed,
}

impl CustomOp1 for ColumnSums {
    fn name(&self) -> &'static str {
        "column-sums"
    }

    forward!(cpu_fwd, CpuStorage, Cpu);
    forward!(cuda_fwd, CudaStorage, Cuda);
    forward!(metal_fwd, MetalStorage, Metal);

    fn bwd(&self, _: &Tensor, _: &Tensor, grad: &Tensor) -> Result<Option<Tensor>> {
        grad.contiguous()?.gather(&self.columns, 1).map(Some)
    }
}
