//! A simulated camera. It takes pictures of the world of a robot's driver in the same application. It moves
//! nothing and opens no world itself.

use core::time::Duration;
use std::collections::VecDeque;

use jde_schema::prelude::*;
use jde_schema::types::CameraInfo;
use jde_sim::{CameraConfig, CameraMount, Delivery, DepthConfig, Lens, RobotId, World, WorldError};

use crate::worlds;

/// Capacity of an image, bytes.
const MAX_BYTES: usize = 640 * 480 * 3;
/// Bytes of a depth.
const DEPTH_BYTES: usize = size_of::<f32>();

/// How long the camera waits for its robot before it warns.
const WARNING_DELAY: Duration = Duration::from_secs(2);

/// A camera on a robot of a simulated world. Two of them side by side on the head are a stereo pair. With
/// `with_depth` it is a depth camera, whose defaults are those of a Kinect.
///
/// It shows the world at the time of its iteration, however rarely the robot's driver iterates: robots
/// continue meanwhile by their last commands. While the robot is not in the world it waits, and warns after
/// two seconds. The robot's own body is not in the picture.
#[derive(Describe)]
#[schema(driver, period = "33ms", budget = "33ms")]
pub struct Camera {
    /// The world file, the same as that of the robot's driver.
    #[modulation(default = "", unit = "file", fixed)]
    world: Modulation<Text<1024>>,
    /// The name in the world file of the robot that carries it.
    #[modulation(default = "", fixed)]
    robot: Modulation<Text<60>>,
    /// Columns of the picture.
    #[modulation(default = 320, min = 1, max = 4096, fixed)]
    width: Modulation<u32>,
    /// Rows of the picture.
    #[modulation(default = 240, min = 1, max = 4096, fixed)]
    height: Modulation<u32>,
    /// Horizontal field of view.
    #[modulation(default = 0.829, unit = "rad", min = 0.01, max = 3.1, fixed)]
    field_of_view: Modulation<f64>,
    /// Position ahead of the head, or of the middle of the body.
    #[modulation(default = 0.0, unit = "m", fixed)]
    x: Modulation<f64>,
    /// Position to the left.
    #[modulation(default = 0.0, unit = "m", fixed)]
    y: Modulation<f64>,
    /// Position above the head, or above the floor.
    #[modulation(default = 0.0, unit = "m", fixed)]
    z: Modulation<f64>,
    /// Angle by which it is turned to the left.
    #[modulation(default = 0.0, unit = "rad", fixed)]
    yaw: Modulation<f64>,
    /// Angle by which it then looks down.
    #[modulation(default = 0.0, unit = "rad", min = -1.6, max = 1.6, fixed)]
    tilt: Modulation<f64>,
    /// Whether the pan-tilt head carries and turns it; otherwise the body carries it.
    #[modulation(default = Flag::new(true), fixed)]
    on_head: Modulation<Flag>,
    /// Whether it measures depths.
    #[modulation(default = Flag::new(false), fixed)]
    with_depth: Modulation<Flag>,
    /// Shortest depth that it measures.
    #[modulation(default = 0.5, unit = "m", min = 0.0, fixed)]
    depth_min: Modulation<f64>,
    /// Longest depth that it measures.
    #[modulation(default = 5.0, unit = "m", fixed)]
    depth_max: Modulation<f64>,
    /// Standard deviation of a depth of 1 m; that of other depths grows with the square of the depth, as for
    /// structured light.
    #[modulation(default = 0.001425, unit = "m", min = 0.0, fixed)]
    depth_noise: Modulation<f64>,
    /// How far to the right of the middle of the picture the optical axis is.
    #[modulation(default = 0.0, unit = "px", fixed)]
    principal_x: Modulation<f64>,
    /// How far below the middle of the picture the optical axis is.
    #[modulation(default = 0.0, unit = "px", fixed)]
    principal_y: Modulation<f64>,
    /// First radial coefficient of the distortion of its lens ("plumb_bob"); negative for a barrel.
    #[modulation(default = 0.0, fixed)]
    k1: Modulation<f64>,
    /// Second radial coefficient.
    #[modulation(default = 0.0, fixed)]
    k2: Modulation<f64>,
    /// First tangential coefficient.
    #[modulation(default = 0.0, fixed)]
    p1: Modulation<f64>,
    /// Second tangential coefficient.
    #[modulation(default = 0.0, fixed)]
    p2: Modulation<f64>,
    /// Third radial coefficient.
    #[modulation(default = 0.0, fixed)]
    k3: Modulation<f64>,
    /// Standard deviation of the red, green and blue of each pixel, in steps of the 256.
    #[modulation(default = 0.0, min = 0.0, max = 100.0, fixed)]
    noise: Modulation<f64>,
    /// Least time from a picture to its arrival. It is stamped with the time at which it was taken.
    #[modulation(default = 0.0, unit = "s", min = 0.0, max = 10.0, fixed)]
    latency: Modulation<f64>,
    /// Greatest time beyond the latency.
    #[modulation(default = 0.0, unit = "s", min = 0.0, max = 10.0, fixed)]
    jitter: Modulation<f64>,
    /// Part of the pictures that never arrive.
    #[modulation(default = 0.0, min = 0.0, max = 1.0, fixed)]
    dropped: Modulation<f64>,
    /// The picture, "rgb8", in the frame of the camera by REP-103: x to the right, y down, z into the
    /// picture. Stamped with the world's time.
    #[export]
    image: Export<Image>,
    /// The depths of the picture's pixels, "32FC1": metres along the optical axis; +∞ is nothing in the range,
    /// -∞ is too near (REP-118, REP-117). Frame and stamp are those of the picture. None without `with_depth`.
    #[export]
    depth: Export<Image>,
    /// The calibration of its pictures.
    #[export]
    camera_info: Export<CameraInfo>,
    /// The world of its robot; set when it wakes.
    key: Option<worlds::Key>,
    capture: CaptureState,
    /// The depths of the picture in progress, in metres.
    depths: Vec<f32>,
    /// The pictures that have not arrived yet, the oldest first.
    waiting: VecDeque<Waiting>,
}

/// A picture on its way.
struct Waiting {
    arrives: Duration,
    /// When it was taken.
    time: Duration,
    picture: Vec<u8>,
    /// Metres; empty without depths.
    depths: Vec<f32>,
}

/// The state of the pictures.
#[derive(Clone, Copy, Debug, Default)]
enum CaptureState {
    /// It woke, and has not iterated yet.
    #[default]
    Woken,
    /// No robot carries it, since this time.
    Waiting(Duration),
    /// No robot carries it, and it has warned.
    Reported,
    /// The newest picture shows the world at this time, ns.
    Published(u64),
}

impl Schema for Camera {
    fn awake(&mut self, cx: &Context) -> Result {
        self.check_names(cx)?;
        self.check_config(cx)?;
        self.check_depth_config(cx)?;
        self.key = Some(worlds::Key::new(cx.application(), self.world.get(cx).as_str()));
        // After a sleep, the world is shown again even if its time is the same.
        self.capture = CaptureState::Woken;
        self.waiting.clear();
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let name = self.robot.get(cx);
        let open = self.key.as_ref().and_then(worlds::find);
        let mut world = open.as_ref().map(worlds::SharedWorld::lock);
        if let Some(world) = &mut world {
            // The result does not depend on which driver advances the world, because a command applies from
            // the time at which its driver gives it.
            world.advance_to(cx.now().as_nanos() as u64);
        }
        let found = match &world {
            Some(world) => find_robot(world, name.as_str())?.map(|robot| (world, robot)),
            None => None,
        };
        let Some((world, robot)) = found else {
            self.wait_for_robot(cx);
            return Ok(());
        };
        self.deliver(cx)?;
        if matches!(self.capture, CaptureState::Published(time) if time == world.now()) {
            return Ok(());
        }
        self.take(cx, world, robot)?;
        self.capture = CaptureState::Published(world.now());
        Ok(())
    }
}

impl Inspect for Camera {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        problems.expect(&self.width, self.check_config(cx));
        problems.expect(&self.depth_max, self.check_depth_config(cx));
        let world = self
            .check_names(cx)
            .and_then(|()| Ok(worlds::load(self.world.get(cx).as_str(), cx.seed())?));
        if let Some(world) = problems.expect(&self.world, world) {
            problems.expect(&self.robot, find_robot(&world, self.robot.get(cx).as_str()));
        }
    }
}

impl Camera {
    /// Checks that a world and a robot are named.
    fn check_names(&self, cx: &Context) -> Result {
        if self.world.get(cx).is_empty() || self.robot.get(cx).is_empty() {
            return Err(
                "it has no world or no robot; give it both, as the robot's driver has them: world = \"worlds/hall.toml\", \
                 robot = \"pioneer\""
                    .into(),
            );
        }
        Ok(())
    }

    /// Checks that the configuration is valid and its pictures fit.
    fn check_config(&self, cx: &Context) -> Result {
        let config = self.config(cx);
        config.check()?;
        check_capacity(&config, "a picture", config.bytes(), "640 x 480")?;
        if self.with_depth.get(cx).get() {
            check_capacity(
                &config,
                "a depth image",
                DEPTH_BYTES * config.pixels(),
                "640 x 360",
            )?;
        }
        Ok(())
    }

    /// Checks that the configuration of the depths is valid.
    fn check_depth_config(&self, cx: &Context) -> Result {
        if let Some(depth) = self.depth_config(cx) {
            depth.check()?;
        }
        Ok(())
    }

    /// Retracts the picture and its depths, and warns once if the robot remains absent.
    fn wait_for_robot(&mut self, cx: &Context) {
        self.waiting.clear();
        self.capture = match self.capture {
            CaptureState::Woken => CaptureState::Waiting(cx.now()),
            CaptureState::Published(_) => {
                self.image.retract(cx);
                self.depth.retract(cx);
                self.camera_info.retract(cx);
                CaptureState::Waiting(cx.now())
            }
            CaptureState::Waiting(since) if cx.now().saturating_sub(since) >= WARNING_DELAY => {
                warn!(
                    cx,
                    "waits for robot `{}` in {}: a `sim/robot` with this `world` and `robot` puts it there, while \
                     a schema imports or commands it",
                    self.robot.get(cx),
                    self.world.get(cx)
                );
                CaptureState::Reported
            }
            waits @ (CaptureState::Waiting(_) | CaptureState::Reported) => waits,
        };
    }

    /// Takes a picture, and publishes it now or when it arrives.
    fn take(&mut self, cx: &Context, world: &World, robot: RobotId) -> Result {
        let (config, depth_config) = (self.config(cx), self.depth_config(cx));
        let time = Duration::from_nanos(world.now());
        let draw = |picture: &mut [u8], depths: &mut Vec<f32>| match &depth_config {
            Some(depth_config) => {
                depths.resize(config.pixels(), 0.0);
                world.picture_with_depths(robot, (&config, depth_config), picture, depths)
            }
            None => world.picture(robot, &config, picture),
        };
        let delivery = Delivery {
            latency: self.latency.get(cx),
            jitter: self.jitter.get(cx),
            dropped: self.dropped.get(cx),
        };
        let Some(delay) = world.delay(robot, &delivery, config.stream)? else {
            return Ok(());
        };
        if delay == Duration::ZERO && self.waiting.is_empty() {
            return self.publish(cx, (&config, time), draw);
        }
        let (mut picture, mut depths) = (vec![0; config.bytes()], Vec::new());
        draw(&mut picture, &mut depths)?;
        let last = self.waiting.back().map_or(Duration::ZERO, |last| last.arrives);
        self.waiting.push_back(Waiting {
            arrives: (cx.now() + delay).max(last),
            time,
            picture,
            depths,
        });
        Ok(())
    }

    /// Publishes the pictures that have arrived.
    fn deliver(&mut self, cx: &Context) -> Result {
        let config = self.config(cx);
        while let Some(first) = self.waiting.pop_front_if(|first| first.arrives <= cx.now()) {
            self.publish(cx, (&config, first.time), |picture, depths| {
                picture.copy_from_slice(&first.picture);
                *depths = first.depths;
                Ok(())
            })?;
        }
        Ok(())
    }

    /// Publishes a picture that `draw` fills, and its depths if it measures them.
    fn publish(
        &mut self,
        cx: &Context,
        (config, time): (&CameraConfig, Duration),
        draw: impl FnOnce(&mut [u8], &mut Vec<f32>) -> Result<(), WorldError>,
    ) -> Result {
        let mut image = self.image.loan(cx);
        describe(&mut image, config, time, ("rgb8", 3));
        draw(image.data.resize(config.bytes()), &mut self.depths)?;
        if self.with_depth.get(cx).get() {
            let mut depth = self.depth.loan(cx);
            describe(&mut depth, config, time, ("32FC1", DEPTH_BYTES));
            let bytes = depth.data.resize(DEPTH_BYTES * config.pixels());
            let (places, _) = bytes.as_chunks_mut::<DEPTH_BYTES>();
            for (place, depth) in places.iter_mut().zip(&self.depths) {
                *place = depth.to_le_bytes();
            }
            depth.publish_at(time);
        }
        let info = calibration(config, image.header);
        // Before the picture: whoever the picture wakes has both.
        self.camera_info.write_at(cx, info, time);
        image.publish_at(time);
        Ok(())
    }

    fn config(&self, cx: &Context) -> CameraConfig {
        CameraConfig {
            width: self.width.get(cx) as usize,
            height: self.height.get(cx) as usize,
            field_of_view: self.field_of_view.get(cx),
            mount: if self.on_head.get(cx).get() {
                CameraMount::Head
            } else {
                CameraMount::Body
            },
            place: [self.x.get(cx), self.y.get(cx), self.z.get(cx)],
            yaw: self.yaw.get(cx),
            tilt: self.tilt.get(cx),
            lens: Lens {
                principal: [self.principal_x.get(cx), self.principal_y.get(cx)],
                distortion: [&self.k1, &self.k2, &self.p1, &self.p2, &self.k3].map(|k| k.get(cx)),
            },
            noise: self.noise.get(cx),
            stream: self.stream(cx),
        }
    }

    /// Returns what it measures of depths; `None` if it measures none.
    fn depth_config(&self, cx: &Context) -> Option<DepthConfig> {
        self.with_depth.get(cx).get().then(|| DepthConfig {
            range_min: self.depth_min.get(cx),
            range_max: self.depth_max.get(cx),
            sigma: self.depth_noise.get(cx),
            stream: self.stream(cx),
        })
    }

    /// Returns what separates its noise: the seed depends on the name of this schema.
    fn stream(&self, cx: &Context) -> u16 {
        cx.seed() as u16
    }
}

fn check_capacity(config: &CameraConfig, what: &str, bytes: usize, largest: &str) -> Result {
    if bytes > MAX_BYTES {
        let (width, height) = (config.width, config.height);
        return Err(format!(
            "{what} of {width} x {height} pixels has {bytes} bytes: expected at most {MAX_BYTES}, as {largest} have; \
             lower width or height"
        )
        .into());
    }
    Ok(())
}

/// Returns what a calibration of the camera would find.
fn calibration(config: &CameraConfig, header: Header) -> CameraInfo {
    let mut info = CameraInfo {
        header,
        ..CameraInfo::pinhole([config.width as u32, config.height as u32], config.field_of_view)
    };
    let [right, down] = config.lens.principal;
    info.k[2] += right;
    info.k[5] += down;
    (info.p[2], info.p[6]) = (info.k[2], info.k[5]);
    info.d.resize(5).copy_from_slice(&config.lens.distortion);
    info
}

/// Fills the fields of an image beside its data.
fn describe(image: &mut Image, config: &CameraConfig, time: Duration, (encoding, bytes): (&str, usize)) {
    image.header = Header::new(time, "camera");
    (image.width, image.height) = (config.width as u32, config.height as u32);
    image.encoding = Text::truncated(encoding);
    image.is_bigendian = 0;
    image.padding = Padding::ZERO;
    image.step = (bytes * config.width) as u32;
}

/// Returns the robot that carries it; `None` while it is not in the world.
pub(crate) fn find_robot(world: &World, name: &str) -> Result<Option<RobotId>> {
    if !world.robot_names().any(|known| known == name) {
        let known: Vec<&str> = world.robot_names().collect();
        return Err(format!(
            "the world `{}` has no robot `{name}`: it has `{}`",
            world.name(),
            known.join("`, `")
        )
        .into());
    }
    Ok(world
        .robots()
        .find(|(_, known)| *known == name)
        .map(|(robot, _)| robot))
}

#[cfg(test)]
mod tests;
