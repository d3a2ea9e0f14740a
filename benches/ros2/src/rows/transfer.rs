//! Messages from rclcpp to rclcpp, out of jde and into jde, in turns: how long each takes, and how many pass.

use std::thread;

use anyhow::{Result, ensure};
use jde_measure::figure::{Figure, Goal, Line};

use super::{BY_ROUTER, DIRECTLY, IDLE, addresses};
use crate::arrivals::{Arrivals, now};
use crate::programs::{Programs, SETTLING};

/// Bytes of the two kinds of messages.
const SIZES: [(&str, u32); 2] = [("64 B", 64), ("900 kB", 640 * 480 * 3)];
/// The time in which each side sends one message of each size, and when each side does after its beginning, ms.
const CYCLE: u32 = 200;
const RCLCPP: u32 = 0;
const JDE: u32 = 33;
const INTO: u32 = 66;
/// When the second size is sent after the first, ms.
const SECOND: u32 = 100;

/// How the driver is configured.
struct Driver {
    what: &'static str,
    listen: &'static str,
    goal: Goal,
}

/// How long messages take.
pub(crate) fn run(programs: &Programs) -> Result<Vec<Line>> {
    let drivers = [
        Driver {
            what: "directly",
            listen: DIRECTLY,
            goal: Goal::AtMost(1.1),
        },
        Driver {
            what: "by the router",
            listen: BY_ROUTER,
            goal: Goal::ReportOnly,
        },
    ];
    let mut lines = Vec::new();
    for driver in drivers {
        let arrivals = exchange(programs, &driver)?;
        for (size, bytes) in SIZES {
            let ages = |side: &str| arrivals.all.ages(&format!("{side}{bytes}"), arrivals.within);
            let rclcpp = ages("rclcpp")?;
            for (what, ours) in [("out of jde", ages("jde")?), ("into jde", ages("into")?)] {
                lines.push(
                    Line::compared(
                        format!("{size} {what}, {}", driver.what),
                        Figure::Time(ours.median()),
                        "rclcpp to rclcpp",
                        Figure::Time(rclcpp.median()),
                        driver.goal,
                    )
                    .paired(ours.ratio_to(&rclcpp)),
                );
            }
        }
    }
    Ok(lines)
}

/// How many messages pass if each side sends without a pause, one side after the other.
pub(crate) fn rate(programs: &Programs) -> Result<Vec<Line>> {
    let mut lines = Vec::new();
    for (size, bytes) in SIZES {
        let mut each = Vec::new();
        for side in ["rclcpp", "jde", "into"] {
            let (all, within) = flood(programs, side, bytes)?;
            let count = all.of(&format!("{side}{bytes}"), within).len();
            ensure!(count > 0, "no message of {bytes} bytes arrived from {side}");
            each.push((within.1 - within.0) as f64 / count as f64);
        }
        for (what, ours) in [("out of jde", each[1]), ("into jde", each[2])] {
            lines.push(Line::compared(
                format!("{size} {what}, without a pause, each"),
                Figure::Time(ours),
                "rclcpp to rclcpp",
                Figure::Time(each[0]),
                Goal::AtMost(1.1),
            ));
        }
    }
    Ok(lines)
}

/// What arrived, and the time that counts.
struct Exchange {
    all: Arrivals,
    within: (u64, u64),
}

/// Lets all sides send in turns.
fn exchange(programs: &Programs, driver: &Driver) -> Result<Exchange> {
    let _router = programs.router()?;
    let topics = |side: &str| SIZES.map(|(_, bytes)| format!("{side}{bytes}"));
    let heard = ["listen".to_owned()]
        .into_iter()
        .chain(topics("rclcpp"))
        .chain(topics("jde"));
    let listen = programs.rclcpp(&heard.collect::<Vec<_>>())?;
    let application = programs.jde("transfer", &application(programs, driver.listen))?;
    let mut arguments = vec!["talk".to_owned()];
    for (side, phase) in [("rclcpp", RCLCPP), ("into", INTO)] {
        for ((_, bytes), second) in SIZES.iter().zip([0, SECOND]) {
            arguments.push(format!("{side}{bytes}"));
            arguments.extend([*bytes, CYCLE, phase + second].map(|number| number.to_string()));
        }
    }
    let talk = programs.rclcpp(&arguments)?;
    thread::sleep(SETTLING);
    let from = now();
    thread::sleep(programs.seconds(6, 60));
    let within = (from, now());
    // The last messages arrive.
    thread::sleep(SETTLING / 4);
    talk.end()?;
    application.terminate()?;
    let mut text = listen.end()?;
    for (_, bytes) in SIZES {
        text += &programs.recorded("transfer", &format!("into{bytes}"))?;
    }
    Ok(Exchange {
        all: Arrivals::read(&text),
        within,
    })
}

/// An application that sends and receives messages of both sizes.
fn application(programs: &Programs, listen: &str) -> String {
    let mut text = format!(
        "name = \"transfer\"\nroots = [\"into64\", \"into921600\"]\nawake = [\"topics\"]\n[schemas.topics]\n\
         type = \"ros2/topics\"\n{}",
        addresses(programs, listen)
    );
    for (_, bytes) in SIZES {
        text +=
            &format!("publish.jde{bytes} = \"talk{bytes}.out\"\nsubscribe.into{bytes} = \"into{bytes}\"\n");
    }
    for ((_, bytes), second) in SIZES.iter().zip([0, SECOND]) {
        text += &format!(
            "[schemas.talk{bytes}]\ntype = \"bench-000/talk\"\nbytes = {bytes}\nevery = \"{CYCLE}ms\"\nphase = \"{}ms\"\n\
             [schemas.into{bytes}]\ntype = \"bench-000/listen\"\nimports = {{ input = \"topics.into{bytes}\" }}\n",
            JDE + second
        );
    }
    text
}

/// Lets one side send as fast as it can.
fn flood(programs: &Programs, side: &str, bytes: u32) -> Result<(Arrivals, (u64, u64))> {
    let _router = programs.router()?;
    let topic = format!("{side}{bytes}");
    let talk = || {
        let words = ["talk", &topic, &bytes.to_string(), "0", "0"];
        programs.rclcpp(&words.map(str::to_owned))
    };
    let listen = || programs.rclcpp(&["listen".to_owned(), topic.clone()]);
    let head = "name = \"rate\"\n";
    let topics = format!(
        "[schemas.topics]\ntype = \"ros2/topics\"\n{}",
        addresses(programs, DIRECTLY)
    );
    let out = format!(
        "{head}{IDLE}{topics}publish.{topic} = \"talk.out\"\n\
         [schemas.talk]\ntype = \"bench-000/talk\"\nbytes = {bytes}\nperiod = \"100us\"\n"
    );
    let into = format!(
        "{head}roots = [\"heard\"]\n{topics}subscribe.{topic} = \"value\"\n\
         [schemas.heard]\ntype = \"bench-000/listen\"\nimports = {{ input = \"topics.value\" }}\n"
    );
    let measure = || {
        thread::sleep(SETTLING);
        let from = now();
        thread::sleep(programs.seconds(2, 5));
        (from, now())
    };
    let (text, within) = match side {
        "into" => {
            let (application, talk) = (programs.jde("rate", &into)?, talk()?);
            let within = measure();
            talk.end()?;
            application.terminate()?;
            let text = programs.recorded("rate", "heard")?;
            (text.replace("heard ", &format!("{topic} ")), within)
        }
        "jde" => {
            let (listen, application) = (listen()?, programs.jde("rate", &out)?);
            let within = measure();
            application.terminate()?;
            (listen.end()?, within)
        }
        _ => {
            let (listen, talk) = (listen()?, talk()?);
            let within = measure();
            talk.end()?;
            (listen.end()?, within)
        }
    };
    Ok((Arrivals::read(&text), within))
}
