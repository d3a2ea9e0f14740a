//! Compressed pictures, in both directions. Threads compress and decompress them, since that takes longer than an
//! iteration may: the newest picture when a thread is free, and none in between.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::{io, thread};

use jde_picture::{Compression, Picture};
use jde_ros_node::{Quality, Topic};
use jde_schema::describe::Type;
use jde_schema::prelude::*;
use jde_schema::types::CompressedImage;

use crate::messages::Codec;

/// The niceness of the threads: that of the threads of the network.
const NICE: i32 = 10;

/// A thread that turns one input after the other into a result.
struct Worker<I, O> {
    inputs: SyncSender<I>,
    results: Receiver<Result<O, String>>,
    is_busy: bool,
}

impl<I: Send + 'static, O: Send + 'static> Worker<I, O> {
    /// The thread ends with the worker, after the input that it has.
    fn start(mut work: impl FnMut(I) -> Result<O, String> + Send + 'static) -> io::Result<Self> {
        let (inputs, waiting) = sync_channel::<I>(1);
        let (finished, results) = sync_channel(1);
        thread::Builder::new()
            .name("pictures".to_owned())
            .spawn(move || {
                // Without the permission the niceness stays the same, which is not an error.
                let _ = rustix::process::nice(NICE);
                // A decoder that panics must not end the pictures after the one that it cannot read.
                let mut work = |input| {
                    let result = catch_unwind(AssertUnwindSafe(|| work(input)));
                    result.unwrap_or_else(|_| Err("a library for pictures failed on this one".to_owned()))
                };
                while let Ok(input) = waiting.recv()
                    && finished.send(work(input)).is_ok()
                {}
            })?;
        Ok(Self {
            inputs,
            results,
            is_busy: false,
        })
    }

    /// Hands over an input, unless the thread is busy.
    fn offer(&mut self, input: impl FnOnce() -> Option<I>) {
        if !self.is_busy
            && let Some(input) = input()
        {
            self.is_busy = self.inputs.try_send(input).is_ok();
        }
    }

    /// Takes the result of an input, once.
    fn take(&mut self) -> Option<Result<O, String>> {
        let result = self.results.try_recv().ok()?;
        self.is_busy = false;
        Some(result)
    }
}

/// Returns the topic of that name with compressed pictures.
pub(crate) fn topic(name: String, quality: Quality) -> Topic {
    Codec::<CompressedImage>::new().topic(name, quality)
}

/// Compresses pictures to messages.
pub(crate) struct Compressor(Worker<Box<Image>, Vec<u8>>);

impl Compressor {
    pub(crate) fn start(compression: Compression) -> io::Result<Self> {
        let (codec, mut message) = (Codec::new(), CompressedImage::boxed());
        let worker = Worker::start(move |image: Box<Image>| {
            let file = compression.compress(&image).map_err(|error| error.to_string())?;
            message.data.clear();
            let written = message.data.extend_from_slice(&file);
            written.map_err(|error| format!("the bytes of its compressed picture: {error}"))?;
            message.header = image.header;
            // The decoders of ROS 2 get blue before red.
            let order = if image.encoding == "mono8" { "" } else { " bgr8" };
            let format = format!("{}; {} compressed{order}", image.encoding, compression.name());
            message.format = Text::truncated(&format);
            Ok(codec.encode(&*message))
        });
        Ok(Self(worker?))
    }

    /// Whether it is still at work on the picture before.
    pub(crate) const fn is_busy(&self) -> bool {
        self.0.is_busy
    }

    /// Hands over the bytes of a picture, with this header.
    pub(crate) fn compress(&mut self, value_type: &Type, value: &[u8], header: Header) {
        self.0.offer(|| {
            let mut image = Image::boxed();
            value_type.copy_into(value, image.as_bytes_mut());
            image.header = header;
            Some(image)
        });
    }

    /// Takes the message of a picture that was handed over.
    pub(crate) fn message(&mut self) -> Option<Result<Vec<u8>, String>> {
        self.0.take()
    }
}

/// A message, when it was measured, and when it arrived.
pub(crate) struct Arrival {
    pub(crate) message: Vec<u8>,
    pub(crate) time: Duration,
    pub(crate) arrived: Duration,
}

/// A picture, and when it arrived.
type Decompressed = (Box<Image>, Duration);

/// Decompresses messages to pictures.
pub(crate) struct Decompressor(Worker<Arrival, Decompressed>);

impl Decompressor {
    pub(crate) fn start() -> io::Result<Self> {
        let (codec, mut message) = (Codec::new(), CompressedImage::boxed());
        let worker = Worker::start(move |arrival: Arrival| {
            let decoded = codec.decode_into(&[&arrival.message], &mut *message);
            decoded.map_err(|error| error.to_string())?;
            let mut image = Image::boxed();
            let read = Picture::read(&message.data).and_then(|picture| picture.write_to(&mut image));
            read.map_err(|error| error.to_string())?;
            image.header = Header {
                stamp: arrival.time.into(),
                ..message.header
            };
            Ok((image, arrival.arrived))
        });
        Ok(Self(worker?))
    }

    /// Hands over the newest message, if it is free and there is one.
    pub(crate) fn decompress(&mut self, newest: impl FnOnce() -> Option<Arrival>) {
        self.0.offer(newest);
    }

    /// Takes the picture of a message that was handed over.
    pub(crate) fn picture(&mut self) -> Option<Result<Decompressed, String>> {
        self.0.take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_on_which_a_library_panics_is_an_error_and_the_next_one_passes() {
        let mut worker = Worker::start(|number: u32| {
            assert_ne!(number, 1, "as a decoder that fails");
            Ok(number)
        })
        .unwrap();
        let mut result = |number| {
            worker.offer(|| Some(number));
            loop {
                if let Some(result) = worker.take() {
                    return result;
                }
                thread::yield_now();
            }
        };
        assert!(result(1).unwrap_err().contains("failed on this one"));
        assert_eq!(result(2), Ok(2));
    }
}
