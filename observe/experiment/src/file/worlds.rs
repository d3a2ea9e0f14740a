//! Worlds as values of an axis or a case: a file, or all files of a folder.

use std::fs;
use std::io::{self, ErrorKind};

use jde_app::Override;
use jde_document::section::{Node, text};
use jde_document::{FaultReport, quote};
use serde_json::Value;

use super::Subject;
use super::axes::{folder, with_modulation};
use crate::experiment::{AxisChoice, WORLD};

/// The worlds of a file, or of all files of a folder, in the order of their names.
pub(super) fn worlds(report: &mut FaultReport, subject: &Subject<'_>, node: &Node) -> Vec<AxisChoice> {
    let Some(written) = text(report, "each of `worlds`", node) else {
        return Vec::new();
    };
    let path = folder(subject.file).join(written.text);
    let entries = match fs::read_dir(&path).and_then(Iterator::collect::<io::Result<Vec<_>>>) {
        Ok(entries) => entries,
        Err(error) if [ErrorKind::NotADirectory, ErrorKind::NotFound].contains(&error.kind()) => {
            return Vec::from_iter(world(report, subject, node));
        }
        Err(error) => {
            let folder = quote(&path.display().to_string());
            report.fault(&node.span(), format!("cannot read the folder {folder}: {error}"));
            return Vec::new();
        }
    };
    let mut names: Vec<_> = entries
        .into_iter()
        .filter_map(|entry| entry.file_name().into_string().ok())
        .filter(|name| name.ends_with(".toml"))
        .collect();
    names.sort();
    if names.is_empty() {
        let folder = quote(&path.display().to_string());
        report.fault(
            &node.span(),
            format!("the folder {folder} has no world, no file .toml"),
        );
    }
    let written = written.text.trim_end_matches('/');
    let files = names.iter().map(|name| format!("{written}/{name}"));
    files
        .map_while(|file| world_of(report, subject, &file, node))
        .collect()
}

/// A world for every simulated robot.
pub(super) fn world(report: &mut FaultReport, subject: &Subject<'_>, node: &Node) -> Option<AxisChoice> {
    let written = text(report, "each of `worlds`", node)?;
    let path = folder(subject.file).join(written.text);
    if !path.is_file() {
        report.fault(
            &node.span(),
            format!("there is no file {}", quote(&path.display().to_string())),
        );
        return None;
    }
    world_of(report, subject, written.text, node)
}

/// A world file, relative to the experiment's file, for every simulated robot.
fn world_of(
    report: &mut FaultReport,
    subject: &Subject<'_>,
    written: &str,
    node: &Node,
) -> Option<AxisChoice> {
    let path = folder(subject.file).join(written);
    let robots: Vec<_> = with_modulation(subject.application, WORLD).collect();
    if robots.is_empty() {
        report
            .fault(&node.span(), "no schema of the application has a world")
            .advise("leave `worlds` out; `set` sets any other modulation");
        return None;
    }
    Some(AxisChoice {
        label: written.into(),
        seed: None,
        overrides: robots
            .into_iter()
            .map(|robot| Override {
                schema: robot.to_owned(),
                variable: WORLD.to_owned(),
                value: Value::from(path.display().to_string()).to_string(),
                folder: folder(subject.file).to_owned(),
                place: None,
            })
            .collect(),
        variant: None,
    })
}
