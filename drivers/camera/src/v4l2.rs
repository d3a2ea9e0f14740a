//! The driver of cameras: connects a feed to a clock and the exports.

use jde_device::port::Backoff;
use jde_device::{ConnectionReport, ConnectionState};
use jde_picture::check_size;
use jde_schema::prelude::*;
use jde_schema::types::CameraInfo;

use crate::calibration;
use crate::feed::{Feed, FeedEvent, State};
use crate::format::Format;
use crate::linux::Camera;

/// A Video4Linux2 camera, which includes most USB cameras.
///
/// The driver reconnects by itself after every loss.
#[derive(Describe)]
#[schema(driver, period = "20ms", budget = "50ms")]
pub struct V4l2 {
    /// The camera's device file.
    #[modulation(default = "/dev/video0", unit = "path", fixed)]
    device: Modulation<Text<256>>,
    /// Columns; the camera uses the nearest size that it supports.
    #[modulation(default = 640, min = 1, fixed)]
    width: Modulation<u32>,
    /// Rows; the camera uses the nearest size that it supports.
    #[modulation(default = 480, min = 1, fixed)]
    height: Modulation<u32>,
    /// Pictures per second; the camera uses the nearest rate that it supports.
    #[modulation(default = 30, unit = "Hz", min = 1, max = 1000, fixed)]
    rate: Modulation<u32>,
    /// The format that the camera sends: "rgb24", "yuyv", "mjpeg" or "grey"; empty for the best that it supports.
    #[modulation(default = "", fixed)]
    format: Modulation<Text<12>>,
    /// The calibration file of the camera, as ROS's `camera_calibration` writes it; empty for none.
    #[modulation(default = "", unit = "file", fixed)]
    calibration: Modulation<Text<1024>>,
    /// The picture, in rgb8.
    #[export(validity = "1s")]
    image: Export<Image>,
    /// The calibration of the file, with the time of the newest picture. None without `calibration`.
    #[export(validity = "1s")]
    camera_info: Export<CameraInfo>,
    /// Whether the camera is connected.
    #[export(lasting)]
    connection: Export<Connection>,
    feed: Option<Feed>,
    info: Option<CameraInfo>,
    report: ConnectionReport,
    /// Whether `image` has a value.
    has_image: bool,
}

impl Schema for V4l2 {
    fn awake(&mut self, cx: &Context) -> Result {
        cx.require_real_time()?;
        if self.feed.is_none() {
            self.info = calibration::read(self.calibration.get(cx).as_str())?;
            self.feed = Some(Feed::new(self.camera(cx)?, Backoff::default()));
        }
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(feed) = &mut self.feed else {
            return Err("it is not awake".into());
        };
        match feed.step(cx.now()) {
            Some(FeedEvent::Picture(picture)) => {
                let mut image = self.image.loan(cx);
                image.header = Header::new(cx.now(), "camera");
                picture.write_to(&mut image)?;
                // Before the picture: whoever the picture wakes has both.
                calibration::publish(cx, &mut self.camera_info, self.info.as_ref(), &image.header);
                image.publish();
                self.has_image = true;
            }
            Some(FeedEvent::Warn(message)) => warn!(cx, "{message}"),
            None => {}
        }
        let connection = match feed.state() {
            State::Idle => ConnectionState::Idle,
            State::Opening(_) => ConnectionState::Connecting,
            State::Open { stream, .. } => ConnectionState::Connected(stream.name()),
            State::Lost { reason, .. } => ConnectionState::Lost(reason),
        };
        if !matches!(connection, ConnectionState::Connected(_)) && std::mem::take(&mut self.has_image) {
            self.image.retract(cx);
            self.camera_info.retract(cx);
        }
        self.report
            .update(cx, &mut self.connection, connection, feed.attempts());
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        // Dropping the feed closes the camera and switches its light off.
        if self.feed.take().is_some() {
            self.has_image = false;
            self.image.retract(cx);
            self.camera_info.retract(cx);
            self.report.retract(cx, &mut self.connection);
        }
    }
}

impl V4l2 {
    fn camera(&self, cx: &Context) -> Result<Camera> {
        let (width, height) = self.size(cx)?;
        Ok(Camera {
            device: self.device.get(cx).to_string(),
            width,
            height,
            rate: self.rate.get(cx),
            format: self.requested_format(cx)?,
        })
    }

    fn size(&self, cx: &Context) -> Result<(u32, u32)> {
        let (width, height) = (self.width.get(cx), self.height.get(cx));
        check_size(width.into(), height.into()).map_err(|error| format!("width and height: {error}"))?;
        Ok((width, height))
    }

    fn requested_format(&self, cx: &Context) -> Result<Option<Format>> {
        let name = self.format.get(cx);
        let format = Format::named(name.as_str());
        if format.is_none() && !name.is_empty() {
            return Err(format!(
                "format = \"{name}\": it can be rgb24, yuyv, mjpeg or grey, or empty for the best that the camera supports"
            )
            .into());
        }
        Ok(format)
    }
}

impl Inspect for V4l2 {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        problems.expect(&self.width, self.size(cx));
        problems.expect(&self.format, self.requested_format(cx));
        problems.expect(
            &self.calibration,
            calibration::read(self.calibration.get(cx).as_str()),
        );
        let device = self.device.get(cx);
        if let Err(missing) = crate::linux::check_device(device.as_str()) {
            problems.unavailable(&self.device, missing);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::thread;

    use jde_device::port::Pty;
    use jde_schema::bench::Bench;
    use jde_watchdog::Watchdog;

    use super::*;

    fn bench(device: &str) -> Bench<V4l2> {
        let mut bench = Bench::new();
        bench.set("device", Text::<256>::new(device));
        bench
    }

    /// Returns the reason why a device is not a camera.
    fn lost(device: &str) -> String {
        let _watchdog = Watchdog::for_test();
        let mut bench = bench(device);
        bench.awake().expect("its configuration is valid");
        loop {
            bench
                .iterate()
                .expect("a driver whose device fails does not fail");
            let connection: Connection = bench.exported("connection").expect("it is exported");
            if connection.state == Connection::LOST {
                assert_eq!(bench.exported_at("image"), None);
                return connection.note.to_string();
            }
            thread::yield_now();
        }
    }

    #[test]
    fn a_device_that_is_not_a_camera_is_reported_by_its_name() {
        assert_eq!(
            lost("/dev/no-such-camera"),
            "/dev/no-such-camera: there is no such device: is the camera plugged in?"
        );
        assert_eq!(lost("/dev/null"), "/dev/null: this is not a camera");
        assert_eq!(lost("/"), "/: this is not a camera");
        let pty = Pty::open().expect("a pseudo-terminal");
        let path = pty.path().display().to_string();
        assert_eq!(lost(&path), format!("{path}: this is not a camera"));
    }

    #[test]
    fn an_inspection_distinguishes_a_missing_camera_from_an_invalid_setting() {
        let mut bench = bench("/dev/null");
        bench.set("format", Text::<12>::new("h264"));
        let problems = bench.inspect().expect("it inspects");
        let problems: Vec<_> = problems
            .iter()
            .map(|problem| (&*problem.modulation, problem.unavailable))
            .collect();
        assert_eq!(problems, [("format", false), ("device", true)]);
    }

    #[test]
    fn a_lost_camera_is_reopened_until_the_driver_sleeps() {
        let mut bench = bench("/dev/no-such-camera");
        bench.awake().expect("its configuration is valid");
        let mut now = Duration::ZERO;
        let mut attempts = 0;
        while attempts < 3 {
            now += Duration::from_millis(100);
            bench.set_now(now);
            bench
                .iterate()
                .expect("a driver whose device fails does not fail");
            attempts = bench
                .exported::<Connection>("connection")
                .expect("it is exported")
                .attempts;
            thread::yield_now();
        }
        assert_eq!(
            bench.log().len(),
            1,
            "the same error is logged once: {:?}",
            bench.log()
        );
        bench.sleep().expect("it sleeps");
        assert_eq!(bench.exported::<Connection>("connection"), None);
    }

    #[test]
    fn invalid_settings_are_refused_before_the_camera_is_opened() {
        let refused = |set: fn(&mut Bench<V4l2>)| {
            let mut bench = bench("/dev/video0");
            set(&mut bench);
            bench.awake().expect_err("the setting is invalid").reason
        };
        let reason = refused(|bench| bench.set("width", 1920_u32));
        assert!(
            reason.starts_with("width and height: it is 1920 x 480 pixels"),
            "{reason}"
        );
        let reason = refused(|bench| bench.set("format", Text::<12>::new("h264")));
        assert!(
            reason.starts_with("format = \"h264\": it can be rgb24"),
            "{reason}"
        );
        assert!(refused(|bench| bench.set_real_time(false)).contains("--lockstep"));
    }
}
