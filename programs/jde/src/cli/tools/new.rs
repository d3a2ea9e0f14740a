//! `jde new`: writes a new schema, driver, application, world, robot or crate of values.

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Args, Subcommand, ValueHint};
use jde_sim::SHIPPED_ROBOTS;

use crate::failure::Failure;
use crate::new::{self, TemplateKind};

/// Write a new schema, driver, application, world, robot or crate of values that builds, passes its test and runs at once.
#[derive(Args)]
#[command(
    subcommand_value_name = "KIND",
    subcommand_help_heading = "Kinds",
    disable_help_subcommand = true,
    after_help = "Examples:
  jde new schema follow
  jde new schema doors --perceptive
  jde new schema follow --cpp
  jde new driver gripper --path ~/robots
  jde new driver thermometer --device
  jde new types doors
  jde new app patrol
  jde new world hall
  jde new world barn --from worlds.txt               a folder of worlds, one for each line
  jde new world lab --from gazebo/lab.sdf --models gazebo/models
  jde new world cave --from stage/simple.world
  jde new world office --from office.yaml            a ROS map
  jde new robot trolley
  jde new robot my-pioneer --from pioneer-3dx
  jde new robot kit --driver base/serial --laser lidar/ld      a real one"
)]
pub(crate) struct New {
    #[command(subcommand)]
    what: What,
    /// The folder in which to make its folder.
    #[arg(long, global = true, value_name = "DIR", default_value = ".", value_hint = ValueHint::DirPath)]
    path: PathBuf,
}

#[derive(Subcommand)]
enum What {
    /// A motor schema, with an application in which it drives a simulated robot.
    Schema {
        #[command(flatten)]
        name: Name,
        /// A perceptive schema instead, with a motor schema that uses what it finds.
        #[arg(long)]
        perceptive: bool,
        /// A father of two children instead.
        #[arg(long, conflicts_with = "perceptive")]
        father: bool,
        /// In C++, with CMake.
        #[arg(long)]
        cpp: bool,
        /// A motor schema in C, with CMake.
        #[arg(long, conflicts_with_all = ["perceptive", "father", "cpp"])]
        c: bool,
        /// In Python.
        #[arg(long, conflicts_with_all = ["cpp", "c"])]
        python: bool,
    },
    /// A driver, with an application that reads it.
    Driver {
        #[command(flatten)]
        name: Name,
        /// A driver of a device at a serial line or behind TCP instead, with an emulator of the device.
        #[arg(long)]
        device: bool,
    },
    /// A crate of values that several plugins share.
    Types {
        #[command(flatten)]
        name: Name,
    },
    /// An application of the existing schemas.
    App {
        #[command(flatten)]
        name: Name,
    },
    /// A world for the simulator: a room, or the converted file of another program.
    World {
        #[command(flatten)]
        name: Name,
        /// Convert this file: a world in SDF or of Stage, a ROS map (YAML) or one of MovingAI, or a list of worlds in the form of
        /// the BARN challenge.
        #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
        from: Option<PathBuf>,
        /// Search the models of an SDF world in this folder, before the ones of GZ_SIM_RESOURCE_PATH and GAZEBO_MODEL_PATH.
        #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath, requires = "from")]
        models: Vec<PathBuf>,
    },
    /// A robot for the simulator: a small one, or a copy of a shipped one. Or an application of a real robot.
    Robot {
        #[command(flatten)]
        name: Name,
        /// Copy this shipped robot.
        #[arg(long, value_name = "ROBOT", value_parser = PossibleValuesParser::new(SHIPPED_ROBOTS.map(|(name, _)| name)))]
        from: Option<String>,
        /// Write an application of a real robot instead, with this driver of its base.
        #[arg(long, value_name = "TYPE", value_parser = PossibleValuesParser::new(new::BASES.map(|base| base.name)))]
        #[arg(requires = "laser", conflicts_with = "from")]
        driver: Option<String>,
        /// The driver of the real robot's lidar.
        #[arg(long, value_name = "TYPE", value_parser = PossibleValuesParser::new(new::LASERS.map(|laser| laser.name)))]
        #[arg(requires = "driver")]
        laser: Option<String>,
        /// Let a person drive the real robot by a gamepad that it reads itself, too.
        #[arg(long, value_name = "TYPE", value_parser = PossibleValuesParser::new(["gamepad"]))]
        #[arg(requires = "driver")]
        teleop: Option<String>,
    },
}

#[derive(Args)]
struct Name {
    /// Its name, such as follow-wall. The folder has the same name.
    name: String,
}

impl New {
    /// Writes the files.
    pub(super) fn run(self) -> Result<(), Failure> {
        let (kind, Name { name }) = match self.what {
            What::Schema {
                name,
                perceptive,
                father,
                cpp,
                c,
                python,
            } => {
                let kind = match (perceptive, father) {
                    (true, _) if cpp => TemplateKind::PerceptiveCpp,
                    (true, _) if python => TemplateKind::PerceptivePython,
                    (true, _) => TemplateKind::Perceptive,
                    (_, true) if cpp => TemplateKind::FatherCpp,
                    (_, true) if python => TemplateKind::FatherPython,
                    (_, true) => TemplateKind::Father,
                    _ if cpp => TemplateKind::MotorCpp,
                    _ if c => TemplateKind::MotorC,
                    _ if python => TemplateKind::MotorPython,
                    _ => TemplateKind::Motor,
                };
                (kind, name)
            }
            What::Driver { name, device } => (
                if device {
                    TemplateKind::Device
                } else {
                    TemplateKind::Driver
                },
                name,
            ),
            What::Types { name } => (TemplateKind::Types, name),
            What::App { name } => (TemplateKind::Application, name),
            What::World { name, from, models } => {
                return new::write_world(&name.name, from.as_deref(), &models, &self.path);
            }
            What::Robot {
                name,
                from,
                driver,
                laser,
                teleop,
            } => {
                let find = |all: &[new::Driver], name: Option<&str>| {
                    all.iter().copied().find(|driver| Some(driver.name) == name)
                };
                let base = find(&new::BASES, driver.as_deref());
                let laser = find(&new::LASERS, laser.as_deref());
                return match base.zip(laser) {
                    Some((base, laser)) => {
                        new::write_real_robot(&name.name, &base, &laser, teleop.is_some(), &self.path)
                    }
                    None => new::write_robot(&name.name, from.as_deref(), &self.path),
                };
            }
        };
        new::write(kind, &name, &self.path)
    }
}
