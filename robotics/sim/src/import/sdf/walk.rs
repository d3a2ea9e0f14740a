//! The parts of a world and of its models, and of the models that they include.

use jde_document::Fault;
use jde_files::Exceeded;

use super::frames::{Scope, Stated};
use super::models::Missing;
use super::population::Places;
use super::pose3::Pose3;
use super::xml::{Node, ROOTS};
use super::{SdfReader, Solid, unused, values};

/// Models that are within each other; what is more would need a larger stack.
const MAX_NESTED: usize = 64;
/// The work for a model: a budget has as many models as a world file has room for.
const MODEL: usize = 1000;

/// Where and by which name a model is put into a scope.
#[derive(Default)]
struct Placing {
    /// Its name, if not its own.
    name: Option<String>,
    stated: Option<Stated>,
    /// The frame in it whose pose is stated.
    placed: Option<String>,
    /// Its parts belong to the scope.
    is_merged: bool,
    /// Its part of the saved state of the world.
    saved: Option<Node>,
}

/// What contains parts: a world or a model.
#[derive(Clone, Copy)]
pub(super) struct Context<'a> {
    pub(super) scope: Scope,
    /// Before the names of the parts.
    pub(super) prefix: &'a str,
    /// It is static, or in something static.
    pub(super) is_static: bool,
    pub(super) saved: Option<&'a Node>,
}

impl SdfReader<'_> {
    /// Reads the parts of a world, or of a model of this name.
    pub(super) fn parts(
        &mut self,
        parent: &Node,
        context: Context<'_>,
        model: Option<&str>,
    ) -> Result<(), Fault> {
        for node in parent.children() {
            self.work(&node)?;
            match (node.name(), model) {
                ("model", _) => {
                    let own = node.attribute("name");
                    let mut states = context.saved.into_iter().flat_map(|saved| {
                        let states: Vec<_> = saved.children_named("model").collect();
                        states
                    });
                    let placing = Placing {
                        saved: states.find(|saved| saved.attribute("name") == own),
                        ..Placing::default()
                    };
                    self.model(&node, context, placing)?;
                }
                ("include", _) => self.include(&node, context)?,
                ("frame", _) => {
                    let stated = self.stated(&node, node.attribute("attached_to").unwrap_or_default());
                    self.frame(&node, context.scope, stated)?;
                }
                ("joint", _) => {
                    let child = node.child("child");
                    let child = child.as_ref().map_or("", Node::text);
                    let stated = self.stated(&node, child);
                    self.frame(&node, context.scope, stated)?;
                    self.leave(&node, "<joint>", unused::JOINT);
                }
                ("link", Some(model)) => self.link(&node, context, model)?,
                ("population", None) => self.population(&node, context)?,
                ("world", _) if parent.name() != "world" => {}
                ("pose" | "static" | "name", Some(_)) | ("state", None) => {}
                _ => self.leave_unused(&node),
            }
        }
        Ok(())
    }

    fn model(&mut self, node: &Node, context: Context<'_>, placing: Placing) -> Result<(), Fault> {
        let work = self.budget.work(MODEL);
        work.map_err(|error| self.fault(&node.place(), error))?;
        let own = placing
            .name
            .as_deref()
            .or(node.attribute("name"))
            .unwrap_or("model");
        let name = format!("{}{own}", context.prefix);
        let saved = placing
            .saved
            .as_ref()
            .filter(|saved| saved.child("pose").is_some());
        let (stated, placed) = match (saved, &placing.stated) {
            // A saved pose is that of the model itself, in the world.
            (Some(saved), _) => (self.stated(saved, ""), String::new()),
            (None, stated) => {
                let own = node.attribute("placement_frame").unwrap_or_default();
                let placed = placing.placed.as_deref().unwrap_or(own);
                let stated = stated.clone().unwrap_or_else(|| self.stated(node, ""));
                (stated, placed.to_owned())
            }
        };
        let id = self.frames.add(context.scope, own, stated, &mut self.budget);
        let id = id.map_err(|error| self.fault(&node.place(), error))?;
        let is_static = node
            .child("static")
            .and_then(|node| values::flag(node.text()))
            .unwrap_or(false);
        let inner = Context {
            scope: self.frames.open(id, &placed),
            prefix: &format!("{name}::"),
            is_static: is_static || context.is_static,
            saved: placing.saved.as_ref(),
        };
        if context.prefix.matches("::").count() >= MAX_NESTED {
            let error = Exceeded::Depth(MAX_NESTED);
            return Err(self.fault(&node.place(), error));
        }
        self.parts(node, inner, Some(&name))?;
        if placing.is_merged {
            let merged = self.frames.merge(id, &mut self.budget);
            merged.map_err(|error| self.fault(&node.place(), error))?;
        }
        Ok(())
    }

    fn link(&mut self, node: &Node, context: Context<'_>, model: &str) -> Result<(), Fault> {
        let stated = self.stated(node, "");
        let link = self.frame(node, context.scope, stated)?;
        for part in node.children() {
            self.work(&part)?;
            if part.name() != "collision" {
                if part.name() != "pose" {
                    self.leave_unused(&part);
                }
                continue;
            }
            let held = self.budget.hold(size_of::<Solid>() + model.len() + 64);
            held.map_err(|error| self.fault(&part.place(), error))?;
            let stated = self.stated(&part, "");
            self.solids.push(Solid {
                node: part,
                scope: context.scope,
                link,
                stated,
                name: model.to_owned(),
                is_static: context.is_static,
            });
        }
        Ok(())
    }

    fn population(&mut self, node: &Node, context: Context<'_>) -> Result<(), Fault> {
        let places = match (Places::read(node), node.child("model")) {
            (Ok(places), Some(model)) => Ok((places, model)),
            (Ok(_), None) => Err("it has no `<model>`".to_owned()),
            (Err(reason), _) => Err(reason),
        };
        let (places, model) = match places {
            Ok(found) => found,
            Err(reason) => {
                self.leave(node, unused::named(node), reason);
                return Ok(());
            }
        };
        let own = model.attribute("name").unwrap_or("model");
        if places.are_drawn {
            let count = places.count;
            self.notes.push(format!(
                "The {count} places of `{own}` are drawn once: Gazebo draws others at each start."
            ));
        }
        for index in 0..places.count {
            self.work(node)?;
            let placing = Placing {
                name: Some(format!("{own}_clone_{index}")),
                stated: Some(Stated {
                    pose: Pose3::at(places.place(index)),
                    ..Stated::ORIGIN
                }),
                ..Placing::default()
            };
            self.model(&model, context, placing)?;
        }
        Ok(())
    }

    fn include(&mut self, node: &Node, context: Context<'_>) -> Result<(), Fault> {
        // It is searched, whatever is found.
        let work = self.budget.work(MODEL);
        work.map_err(|error| self.fault(&node.place(), error))?;
        let uri = node
            .child("uri")
            .map(|uri| uri.text().to_owned())
            .unwrap_or_default();
        let from = node.file().unwrap_or(self.path);
        let found = match uri.is_empty() {
            true => Err(Missing::Because("it has no `<uri>`".to_owned())),
            false => self.models.find(&uri, from, &mut self.budget),
        };
        let file = match found {
            Ok(file) => file,
            Err(Missing::Floor) => return Ok(()),
            Err(Missing::Because(reason)) => {
                self.leave(node, format_args!("the model {uri}"), reason);
                return Ok(());
            }
        };
        if self.open.contains(&file) {
            self.leave(node, format_args!("the model {uri}"), "it contains itself");
            return Ok(());
        }
        let document = match self.models.read(&file, &mut self.budget) {
            Ok(document) => document,
            Err(reason) => {
                self.leave(node, format_args!("the model {uri}"), reason);
                return Ok(());
            }
        };
        let root = document.root(&ROOTS);
        let top = root.as_ref().and_then(|root| {
            let mut tops = ["model", "actor", "light"].into_iter();
            tops.find_map(|name| root.child(name))
        });
        let Some(top) = top else {
            let reason = format!("{} has no model", file.display());
            self.leave(node, format_args!("the model {uri}"), reason);
            return Ok(());
        };
        if top.name() != "model" {
            self.leave_unused(&top);
            return Ok(());
        }
        for part in node.children() {
            if !matches!(
                part.name(),
                "uri" | "name" | "pose" | "placement_frame" | "static"
            ) {
                self.leave_unused(&part);
            }
        }
        let text = |name: &str| node.child(name).map(|node| node.text().to_owned());
        let placing = Placing {
            name: text("name").filter(|name| !name.is_empty()),
            stated: node.child("pose").is_some().then(|| self.stated(node, "")),
            placed: text("placement_frame"),
            is_merged: node.attribute("merge").and_then(values::flag).unwrap_or(false),
            saved: None,
        };
        let stated_static = text("static").and_then(|text| values::flag(&text));
        let context = Context {
            is_static: context.is_static || stated_static.unwrap_or(false),
            saved: None,
            ..context
        };
        self.open.push(file);
        let read = self.model(&top, context, placing);
        self.open.pop();
        read
    }
}
