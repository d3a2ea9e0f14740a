//! Convolution and pooling of rows and of pictures.

use super::elementwise::greater;
use super::{Arity, Operator, TAP};
use crate::attributes::Attributes;
use crate::tensor::Tensor;

/// How a window moves over one or two dimensions. A row is a picture of the height 1.
#[derive(Clone, Debug)]
struct Window {
    strides: Option<Vec<i64>>,
    dilations: Option<Vec<i64>>,
    pads: Option<Vec<i64>>,
    same: Option<bool>,
}

/// A window along one axis of an input.
#[derive(Clone, Copy, Debug)]
struct Along {
    side: usize,
    kernel: usize,
    stride: usize,
    dilation: usize,
    before: usize,
    /// The number of places.
    count: usize,
}

/// Compiles an operator of this family.
pub(super) fn compile(
    name: &str,
    attributes: &Attributes<'_>,
    opset: i64,
) -> Result<Option<(Arity, Operator)>, String> {
    Ok(Some(match name {
        "Conv" => {
            attributes.ignore(&["kernel_shape"]);
            let (window, group) = (Window::read(attributes)?, attributes.integer("group", 1)?);
            let group = usize::try_from(group)
                .ok()
                .filter(|group| *group > 0)
                .ok_or("`group` is below 1")?;
            (
                (3, 1),
                Box::new(move |inputs, outputs| {
                    convolve(
                        inputs.get(0)?,
                        inputs.get(1)?,
                        inputs.optional(2),
                        &window,
                        group,
                        &mut outputs[0],
                    )
                }),
            )
        }
        "MaxPool" | "AveragePool" => {
            attributes.only("ceil_mode", 0, "export the network with ceil_mode=False")?;
            let is_mean = name == "AveragePool";
            let counts_pads = is_mean && attributes.integer("count_include_pad", 0)? != 0;
            if !is_mean {
                attributes.only("storage_order", 0, "it concerns indices, which are not run")?;
            }
            let kernel = attributes
                .integers("kernel_shape")?
                .ok_or("it states no `kernel_shape`")?
                .to_vec();
            let window = Window::read(attributes)?;
            if is_mean && opset < 19 && window.dilations.is_some() {
                return Err("`dilations` of a mean are of opset 19 and later".to_owned());
            }
            (
                (1, 1),
                Box::new(move |inputs, outputs| {
                    pool(
                        inputs.get(0)?,
                        &kernel,
                        &window,
                        is_mean,
                        counts_pads,
                        &mut outputs[0],
                    )
                }),
            )
        }
        "GlobalAveragePool" => (
            (1, 1),
            Box::new(|inputs, outputs| {
                let input = inputs.get(0)?;
                let kernel: Vec<i64> = input.shape.iter().skip(2).map(|side| *side as i64).collect();
                let window = Window {
                    strides: None,
                    dilations: None,
                    pads: None,
                    same: None,
                };
                pool(input, &kernel, &window, true, false, &mut outputs[0])
            }),
        ),
        _ => return Ok(None),
    }))
}

impl Window {
    fn read(attributes: &Attributes<'_>) -> Result<Self, String> {
        let list = |name| Ok::<_, String>(attributes.integers(name)?.map(<[i64]>::to_vec));
        let (pads, auto) = (list("pads")?, attributes.text("auto_pad", "NOTSET")?);
        let same = match auto {
            "NOTSET" | "VALID" => None,
            "SAME_UPPER" => Some(false),
            "SAME_LOWER" => Some(true),
            other => return Err(format!("`auto_pad` is `{other}`")),
        };
        if auto != "NOTSET" && pads.as_ref().is_some_and(|pads| pads.iter().any(|pad| *pad != 0)) {
            return Err("it states both `pads` and `auto_pad`".to_owned());
        }
        Ok(Self {
            strides: list("strides")?,
            dilations: list("dilations")?,
            pads,
            same,
        })
    }

    /// Returns the window along each of two axes.
    fn over(&self, sides: &[usize], kernel: &[usize]) -> Result<[Along; 2], String> {
        let rank = sides.len();
        let lists = [
            (&self.strides, rank),
            (&self.dilations, rank),
            (&self.pads, 2 * rank),
        ];
        if rank != kernel.len()
            || lists
                .iter()
                .any(|(list, length)| list.as_ref().is_some_and(|list| list.len() != *length))
        {
            return Err("its kernel, strides, dilations or pads are not of its dimensions".to_owned());
        }
        let number = |list: &Option<Vec<i64>>, at: usize, default: i64| {
            let stated = list.as_ref().map_or(default, |list| list[at]);
            usize::try_from(stated)
                .ok()
                .filter(|number| *number <= 1 << 16)
                .ok_or_else(|| format!("it states {stated}"))
        };
        let along = |at: usize| {
            let (stride, dilation) = (
                number(&self.strides, at, 1)?.max(1),
                number(&self.dilations, at, 1)?.max(1),
            );
            let (side, kernel) = (sides[at], kernel[at]);
            let reach = kernel
                .checked_sub(1)
                .and_then(|last| last.checked_mul(dilation))
                .ok_or("its kernel is empty")?
                + 1;
            let (before, after) = match self.same {
                None => (number(&self.pads, at, 0)?, number(&self.pads, at + rank, 0)?),
                Some(is_lower) => {
                    let whole = ((side.div_ceil(stride).max(1) - 1) * stride + reach).saturating_sub(side);
                    let less = whole / 2;
                    if is_lower {
                        (whole - less, less)
                    } else {
                        (less, whole - less)
                    }
                }
            };
            let room = (side + before + after).checked_sub(reach);
            let room = room.ok_or_else(|| format!("its kernel is larger than its input of {side}"))?;
            let count = room / stride + 1;
            Ok::<_, String>(Along {
                side,
                kernel,
                stride,
                dilation,
                before,
                count,
            })
        };
        let row = Along {
            side: 1,
            kernel: 1,
            stride: 1,
            dilation: 1,
            before: 0,
            count: 1,
        };
        match rank {
            1 => Ok([row, along(0)?]),
            2 => Ok([along(0)?, along(1)?]),
            _ => Err(format!("{rank} dimensions are not run; 1 and 2 are")),
        }
    }
}

impl Along {
    /// Returns the places in the input that the window covers at a place, with their numbers in the kernel.
    fn covered(self, at: usize) -> impl Iterator<Item = (usize, usize)> + Clone {
        (0..self.kernel).filter_map(move |index| {
            let place = (at * self.stride + index * self.dilation).checked_sub(self.before)?;
            (place < self.side).then_some((index, place))
        })
    }
}

/// Returns the sizes of the batch and of the channels, and the sides of a picture.
fn split(shape: &[usize]) -> Result<(usize, usize, &[usize]), String> {
    match shape {
        [batch, channels, sides @ ..] if !sides.is_empty() => Ok((*batch, *channels, sides)),
        _ => Err(format!("it takes pictures or rows with channels, not {shape:?}")),
    }
}

fn convolve(
    input: &Tensor,
    weights: &Tensor,
    bias: Option<&Tensor>,
    window: &Window,
    group: usize,
    to: &mut Tensor,
) -> Result<(), String> {
    let ((batch, channels, sides), (kernels, depth, kernel)) = (split(&input.shape)?, split(&weights.shape)?);
    if depth * group != channels || kernels % group != 0 || bias.is_some_and(|bias| bias.shape != [kernels]) {
        return Err(format!(
            "the weights {:?} do not fit {:?} in {group} groups",
            weights.shape, input.shape
        ));
    }
    let [down, right] = window.over(sides, kernel)?;
    let mut shape = vec![batch, kernels];
    shape.extend([down.count, right.count].iter().skip(2 - sides.len()));
    let (numbers, factors) = (input.floats()?, weights.floats()?);
    let bias = bias.map(Tensor::floats).transpose()?;
    let (plane, taps) = (down.side * right.side, down.kernel * right.kernel);
    let out = down.count * right.count;
    let room = to.room(
        &shape,
        TAP.saturating_mul(depth.saturating_mul(taps).saturating_add(1)),
    )?;
    for picture in 0..batch {
        for output in 0..kernels {
            let first = output / (kernels / group) * depth;
            let to = &mut room[(picture * kernels + output) * out..][..out];
            to.fill(bias.map_or(0.0, |bias| bias[output]));
            for channel in 0..depth {
                let from = &numbers[(picture * channels + first + channel) * plane..][..plane];
                let factors = &factors[(output * depth + channel) * taps..][..taps];
                for y in 0..down.count {
                    for (index_y, place_y) in down.covered(y) {
                        let (line, factors) = (
                            &from[place_y * right.side..][..right.side],
                            &factors[index_y * right.kernel..],
                        );
                        for x in 0..right.count {
                            let covered = right.covered(x);
                            let sum: f32 = covered
                                .map(|(index_x, place_x)| factors[index_x] * line[place_x])
                                .sum();
                            to[y * right.count + x] += sum;
                        }
                    }
                }
            }
        }
    }
    Ok(())
}

fn pool(
    input: &Tensor,
    kernel: &[i64],
    window: &Window,
    is_mean: bool,
    counts_pads: bool,
    to: &mut Tensor,
) -> Result<(), String> {
    let (batch, channels, sides) = split(&input.shape)?;
    let kernel: Option<Vec<usize>> = kernel.iter().map(|side| usize::try_from(*side).ok()).collect();
    let [down, right] = window.over(sides, &kernel.ok_or("`kernel_shape` is below 0")?)?;
    let mut shape = vec![batch, channels];
    shape.extend([down.count, right.count].iter().skip(2 - sides.len()));
    let plane = down.side * right.side;
    let numbers = input.floats()?;
    let taps = down.kernel.saturating_mul(right.kernel);
    let mut results = to.room(&shape, taps.saturating_mul(TAP))?.iter_mut();
    for from in numbers.chunks_exact(plane.max(1)) {
        for (y, x) in (0..down.count).flat_map(|y| (0..right.count).map(move |x| (y, x))) {
            let covered = down
                .covered(y)
                .flat_map(|(_, y)| right.covered(x).map(move |(_, x)| from[y * right.side + x]));
            let result = match is_mean {
                false => covered.fold(f32::NEG_INFINITY, greater),
                true => {
                    let (sum, count) =
                        covered.fold((0.0, 0_usize), |(sum, count), number| (sum + number, count + 1));
                    let count = if counts_pads {
                        down.kernel * right.kernel
                    } else {
                        count
                    };
                    sum / count as f32
                }
            };
            if let Some(to) = results.next() {
                *to = result;
            }
        }
    }
    Ok(())
}
