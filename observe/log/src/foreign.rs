//! Messages of other programs as values of the standard types, which have room for a fixed number of elements.

use jde_abi::describe::Type;
use jde_ros::cdr;
use jde_types::{
    Beams, ForeignPicture, Frame, Header, Image, LaserScan, PictureFault, Time, Unmeasured, Value,
};

/// Why a message is no value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// It is not in the form of its type.
    #[error(transparent)]
    Form(#[from] cdr::Error),
    /// It is no scan.
    #[error("{0}")]
    Scan(Unmeasured),
    /// It is no picture that schemas read.
    #[error("{0}")]
    Picture(PictureFault),
}

/// Replaces a value by that of a message. `on_cut` is told of each text that is cut: the field, and its capacity in bytes.
///
/// # Errors
/// [`Error`]. The contents of `value` are unspecified then.
///
/// # Panics
/// If there are not as many bytes as the type has.
pub(crate) fn decode_into(
    value_type: &Type,
    message: &[u8],
    value: &mut [u8],
    on_cut: &mut dyn FnMut(&str, usize),
) -> Result<(), Error> {
    if value_type.name == "sensor_msgs/msg/Image" && value_type.bytes == size_of::<Image>() {
        let mut image = Image::boxed();
        picture(message, on_cut)?
            .write_to(&mut image)
            .map_err(Error::Picture)?;
        value_type.copy_into(image.as_bytes(), value);
        return Ok(());
    }
    let decoded = cdr::decode_cutting(value_type, message, value, &mut |field, capacity| {
        on_cut(field, capacity)
    });
    let is_scan =
        value_type.name == "sensor_msgs/msg/LaserScan" && value_type.bytes == size_of::<LaserScan>();
    if is_scan && matches!(decoded, Err(cdr::Error::Capacity { .. })) {
        // The texts have been cut before.
        return scan(message, value);
    }
    Ok(decoded?)
}

/// Merges the beams of a scan that has more than fit.
fn scan(message: &[u8], value: &mut [u8]) -> Result<(), Error> {
    let mut reader = cdr::Reader::new(message)?;
    let header = header(&mut reader, &mut |_, _| ())?;
    let mut number = |field: &str| Ok::<_, cdr::Error>(f32::from_le_bytes(reader.number(field)?));
    let angles = [
        number("angle_min")?,
        number("angle_max")?,
        number("angle_increment")?,
    ];
    let (time_increment, scan_time) = (number("time_increment")?, number("scan_time")?);
    let limits = [number("range_min")?, number("range_max")?];
    let mut list = |field: &str| {
        let count = reader.length(field)?;
        let align = if count > 0 { 4 } else { 1 };
        let bytes = reader.take(align, count.saturating_mul(4), field)?;
        let numbers = bytes
            .as_chunks::<4>()
            .0
            .iter()
            .map(|bytes| f32::from_le_bytes(*bytes));
        Ok::<Vec<f32>, cdr::Error>(numbers.collect())
    };
    let (ranges, intensities) = (list("ranges")?, list("intensities")?);
    reader.finish()?;
    let beams = Beams {
        header,
        angles,
        time_increment,
        scan_time,
        limits,
        ranges: &ranges,
        intensities: &intensities,
    };
    let mut merged = LaserScan::boxed();
    beams.write_to(0.0, &mut merged).map_err(Error::Scan)?;
    value.copy_from_slice(merged.as_bytes());
    Ok(())
}

fn picture<'a>(
    message: &'a [u8],
    on_cut: &mut dyn FnMut(&str, usize),
) -> Result<ForeignPicture<'a>, cdr::Error> {
    let mut reader = cdr::Reader::new(message)?;
    let header = header(&mut reader, on_cut)?;
    let mut size = |field: &str| Ok::<_, cdr::Error>(u32::from_le_bytes(reader.number(field)?));
    let (height, width) = (size("height")?, size("width")?);
    let encoding = reader.text("encoding")?;
    let [is_bigendian] = reader.number("is_bigendian")?;
    let step = u32::from_le_bytes(reader.number("step")?);
    let count = reader.length("data")?;
    let data = reader.take(1, count, "data")?;
    reader.finish()?;
    Ok(ForeignPicture {
        header,
        height,
        width,
        encoding,
        is_bigendian: is_bigendian != 0,
        step,
        data,
    })
}

fn header(reader: &mut cdr::Reader<'_>, on_cut: &mut dyn FnMut(&str, usize)) -> Result<Header, cdr::Error> {
    let stamp = Time {
        sec: i32::from_le_bytes(reader.number("sec")?),
        nanosec: u32::from_le_bytes(reader.number("nanosec")?),
    };
    let text = reader.text("frame_id")?;
    let frame_id = Frame::truncated(text);
    if frame_id.len() < text.len() {
        on_cut("frame_id", Frame::describe().fields[0].form.capacity());
    }
    Ok(Header { stamp, frame_id })
}
