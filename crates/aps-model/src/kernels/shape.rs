//! The sizes of a convolution.

/// Sizes of a 2-D convolution without dilation or groups, in PyTorch's terms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ConvShape {
    pub batch: usize,
    pub in_channels: usize,
    pub height: usize,
    pub width: usize,
    pub out_channels: usize,
    /// (vertical, horizontal)
    pub kernel: (usize, usize),
    pub steps: Steps,
}

/// Steps of a kernel over an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Steps {
    /// Pixels from one output to the next: (vertical, horizontal).
    pub stride: (usize, usize),
    /// Pixels added on each side: (vertical, horizontal).
    pub padding: (usize, usize),
    /// If true, the pixels added to the left and right are those of the other end of the row, else zeros, as above and below.
    pub is_circular: bool,
}

impl Steps {
    /// The same stride in both directions, and zeros around.
    pub fn new(stride: usize, padding: (usize, usize)) -> Self {
        Self {
            stride: (stride, stride),
            padding,
            is_circular: false,
        }
    }

    /// Returns true when every pixel of the image has a window around it, zeros being added at the border.
    pub fn is_dense(&self) -> bool {
        self.stride == (1, 1) && !self.is_circular
    }
}

impl ConvShape {
    /// Returns true when the padded image holds the kernel at least once, and no size is zero.
    pub fn is_valid(&self) -> bool {
        let (kh, kw) = self.kernel;
        let sizes = [self.batch, self.in_channels, self.out_channels, kh, kw];
        sizes.iter().all(|&n| n > 0)
            && self.steps.stride.0 > 0
            && self.steps.stride.1 > 0
            && self.height + 2 * self.steps.padding.0 >= kh
            && self.width + 2 * self.steps.padding.1 >= kw
            && !(self.steps.is_circular && self.steps.padding.1 > self.width)
    }

    pub fn out_height(&self) -> usize {
        (self.height + 2 * self.steps.padding.0 - self.kernel.0) / self.steps.stride.0 + 1
    }

    pub fn out_width(&self) -> usize {
        (self.width + 2 * self.steps.padding.1 - self.kernel.1) / self.steps.stride.1 + 1
    }

    /// Returns the shape of the output: (batch, channels, height, width).
    pub fn out_dims(&self) -> [usize; 4] {
        let (height, width) = (self.out_height(), self.out_width());
        [self.batch, self.out_channels, height, width]
    }

    /// Pixels of one channel of an output image.
    pub fn out_pixels(&self) -> usize {
        self.out_height() * self.out_width()
    }

    /// Pixels of one channel of an input image.
    pub fn in_pixels(&self) -> usize {
        self.height * self.width
    }

    /// Input values that one output value is a sum over: rows of the unfolded input.
    pub fn taps(&self) -> usize {
        self.in_channels * self.kernel.0 * self.kernel.1
    }

    /// Returns true when the unfolded input is the input itself.
    pub fn is_pointwise(&self) -> bool {
        self.kernel == (1, 1) && self.steps.stride == (1, 1) && self.steps.padding == (0, 0)
    }

    pub fn input_len(&self) -> usize {
        self.batch * self.in_channels * self.in_pixels()
    }

    pub fn output_len(&self) -> usize {
        self.batch * self.out_channels * self.out_pixels()
    }

    pub fn weight_len(&self) -> usize {
        self.out_channels * self.taps()
    }

    /// Returns true when images are large enough to be convolved one by one; small ones are convolved together, so that
    /// the matrix product has enough columns.
    pub fn is_by_image(&self) -> bool {
        self.batch >= 4 && self.out_pixels() >= 64
    }
}
