//! Takes a picture in a world and writes it as a PNG file.
//!
//! `cargo run -p jde-sim --example picture -- worlds/hall.toml pioneer hall.png 12` waits twelve seconds of
//! the world's time. The other robots of the world are at their starts. Two more numbers are pan and tilt in
//! degrees.

use std::error::Error;
use std::fs::File;
use std::io::BufWriter;

use jde_sim::{CameraConfig, HeadCommand, RobotConfig, World};

const USAGE: &str = "picture WORLD ROBOT FILE.png [SECONDS [PAN_DEG TILT_DEG]]";

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [world, robot, file, rest @ ..] = arguments.as_slice() else {
        return Err(USAGE.into());
    };
    let rest: Vec<f64> = rest.iter().map(|text| text.parse()).collect::<Result<_, _>>()?;
    let number = |index: usize| rest.get(index).copied().unwrap_or(0.0);

    let mut world = World::load(world, 1)?;
    let names: Vec<String> = world.robot_names().map(str::to_owned).collect();
    let mut own = None;
    for name in names {
        let id = world.add_robot(&name, RobotConfig::default())?;
        if name == *robot {
            own = Some(id);
        }
    }
    let robot = own.ok_or(USAGE)?;
    world.command_head(
        robot,
        HeadCommand {
            pan: number(1).to_radians(),
            tilt: number(2).to_radians(),
            pan_speed: 10.0,
            tilt_speed: 10.0,
        },
    )?;
    world.advance_to((number(0).max(3.0) * 1e9) as u64);

    let camera = CameraConfig {
        width: 640,
        height: 480,
        ..CameraConfig::default()
    };
    let mut picture = vec![0; camera.bytes()];
    world.picture(robot, &camera, &mut picture)?;
    let mut encoder = png::Encoder::new(
        BufWriter::new(File::create(file)?),
        camera.width as u32,
        camera.height as u32,
    );
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header()?.write_image_data(&picture)?;
    Ok(())
}
