//! Video4Linux2 cameras: opening, choice of format and size, and reading without blocking. The contents of
//! pictures are not examined.

use std::fs;
use std::io::{self, ErrorKind};
use std::os::unix::fs::{FileTypeExt, MetadataExt};

use linuxvideo::format::{PixFormat, PixelFormat};
use linuxvideo::stream::ReadStream;
use linuxvideo::{BufType, CapabilityFlags, Device, Fract};
use rustix::fs::{Access, OFlags, access, fcntl_getfl, fcntl_setfl, major};

use crate::feed::{Source, Stream};
use crate::format::{Format, Shape};

/// The kernel's major number of video devices.
const VIDEO: u32 = 81;

/// A camera, and its requested settings.
#[derive(Clone, Debug)]
pub(crate) struct Camera {
    pub(crate) device: String,
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// Pictures per second; the camera uses the nearest rate that it supports.
    pub(crate) rate: u32,
    pub(crate) format: Option<Format>,
}

/// An open camera.
struct OpenStream {
    stream: ReadStream,
    shape: Shape,
    name: String,
}

impl Source for Camera {
    fn open(&self) -> Result<Box<dyn Stream>, String> {
        let open = self.start().map_err(|error| error.of(&self.device))?;
        Ok(Box::new(open))
    }

    fn device(&self) -> &str {
        &self.device
    }
}

enum OpenError {
    Io(io::Error),
    Message(String),
}

impl OpenError {
    /// The message for the operator.
    fn of(self, device: &str) -> String {
        match self {
            Self::Io(error) => describe_error(&error, device),
            Self::Message(message) => format!("{device}: {message}"),
        }
    }
}

/// Checks that a video device exists and this user may open it. Opens nothing.
pub(crate) fn check_device(device: &str) -> Result<(), String> {
    let check = || {
        is_video(device)?;
        access(device, Access::READ_OK | Access::WRITE_OK).map_err(io::Error::from)?;
        Ok(())
    };
    check().map_err(|error: OpenError| error.of(device))
}

fn is_video(device: &str) -> Result<(), OpenError> {
    let file = fs::metadata(device)?;
    if !file.file_type().is_char_device() || major(file.rdev()) != VIDEO {
        return Err(OpenError::Message("this is not a camera".to_owned()));
    }
    Ok(())
}

impl From<io::Error> for OpenError {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

impl From<String> for OpenError {
    fn from(message: String) -> Self {
        Self::Message(message)
    }
}

impl Camera {
    fn start(&self) -> Result<OpenStream, OpenError> {
        // Opening other files can do harm or block: a pipe waits for its writer, a tty raises its lines.
        is_video(&self.device)?;
        let device = Device::open(&self.device)?;
        let capabilities = device.capabilities()?;
        if !capabilities
            .device_capabilities()
            .contains(CapabilityFlags::VIDEO_CAPTURE | CapabilityFlags::STREAMING)
        {
            return Err(OpenError::Message(
                "this device sends no pictures: a camera has several, try the one with the next lower number"
                    .to_owned(),
            ));
        }
        let card = capabilities.card().to_owned();
        let supported = device
            .formats(BufType::VIDEO_CAPTURE)
            .map(|format| Ok(format?.pixel_format().as_fourcc()));
        let code = Format::choose(self.format, &supported.collect::<io::Result<Vec<_>>>()?)?;
        let requested = PixFormat::new(self.width, self.height, PixelFormat::from_fourcc(code));
        let capture = device.video_capture(requested)?;
        let actual = capture.format();
        let shape = Shape::from_driver(
            actual.pixel_format().as_fourcc(),
            actual.width(),
            actual.height(),
            actual.bytes_per_line(),
        )?;
        // Some cameras do not support a choice of rate, and use their own.
        let rate = capture.set_frame_interval(Fract::new(1, self.rate.max(1)));
        let rate = rate
            .ok()
            .filter(|rate| rate.numerator() > 0 && rate.denominator() > 0);
        let rate = rate
            .map(|rate| format!(", {:.0} in a second", 1.0 / rate.as_f32()))
            .unwrap_or_default();
        let stream = capture.into_stream()?;
        let flags = fcntl_getfl(&stream).map_err(io::Error::from)?;
        fcntl_setfl(&stream, flags | OFlags::NONBLOCK).map_err(io::Error::from)?;
        let name = format!("{card}, {} x {}{rate}", shape.width, shape.height);
        Ok(OpenStream { stream, shape, name })
    }
}

impl Stream for OpenStream {
    fn name(&self) -> &str {
        &self.name
    }

    fn shape(&self) -> Shape {
        self.shape
    }

    fn newest(&mut self, into: &mut Vec<u8>) -> Result<bool, String> {
        let mut arrived = false;
        loop {
            let dequeued = self.stream.dequeue(|view| {
                if !view.is_error() {
                    into.clear();
                    into.extend_from_slice(&view);
                }
                Ok(!view.is_error())
            });
            match dequeued {
                Ok(is_complete) => arrived |= is_complete,
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(arrived),
                Err(error) => return Err(format!("it is gone: was it unplugged? ({error})")),
            }
        }
    }
}

fn describe_error(error: &io::Error, device: &str) -> String {
    match error.kind() {
        ErrorKind::NotFound => format!("{device}: there is no such device: is the camera plugged in?"),
        ErrorKind::PermissionDenied => format!(
            "{device}: Permission denied: add yourself to the group video (sudo usermod -aG video $USER) and log in again"
        ),
        ErrorKind::ResourceBusy => format!("{device}: another program has it open: close that first"),
        _ if error.raw_os_error() == Some(rustix::io::Errno::NOTTY.raw_os_error()) => {
            format!("{device}: this is not a camera")
        }
        _ => format!("{device}: {error}"),
    }
}
