//! Gestures on the scenes of panels, which are sent to the schemas that draw them: a click on a shape or on
//! the ground, a drag that begins on a shape, and keys after a click on the scene.

use eframe::egui::{Pos2, Response, Ui};
use glam::{Affine3A, Vec2, Vec3};
use jde_panel::{Gesture, Item, Solid, Wants};

use super::hit;
use super::orbit::Eye;
use super::scene_data::SceneData;
use crate::canvas::Gestures;

/// Maximum distance of a drag, as a multiple of the distance of the view's target.
const MAX_DRAG_DISTANCE: f32 = 4.0;

/// Gestures in progress, kept from frame to frame.
#[derive(Default)]
pub(crate) struct SceneGestures {
    gestures: Gestures,
    held: Option<TouchedScene>,
}

/// The scene of the last click or drag.
struct TouchedScene {
    schema: String,
    scene: String,
    /// The position in the frame of the odometry.
    at: Vec3,
    /// Whether a shape was hit rather than the ground.
    shape: bool,
}

/// A scene that requests gestures.
struct Scene<'a> {
    schema: &'a str,
    id: &'a str,
    frame: Affine3A,
    solids: &'a [Solid],
    wants: Wants,
}

impl SceneGestures {
    /// Whether a drag is sent to a scene, so that the eye stays.
    pub(crate) fn drags(&self) -> bool {
        self.gestures.drags()
    }

    /// Whether keys are sent to a scene.
    pub(crate) fn types(&self, seen: &SceneData) -> bool {
        self.scene(&scenes(seen)).is_some_and(|scene| scene.wants.keys)
    }

    /// The gestures of this frame, each with its schema.
    pub(crate) fn gestures(
        &mut self,
        ui: &Ui,
        response: &Response,
        eye: &Eye,
        seen: &SceneData,
    ) -> Vec<(String, Gesture)> {
        let scenes = scenes(seen);
        let at = if response.clicked() || response.secondary_clicked() || response.middle_clicked() {
            response.interact_pointer_pos()
        } else if response.drag_started() {
            ui.input(|input| input.pointer.press_origin())
        } else {
            None
        };
        let mut gestures = Vec::new();
        if let Some(at) = at {
            let held = scene_at(eye, screen(response, at), &scenes);
            let same = |before: &TouchedScene| {
                let now = held.as_ref().map(|held| (&held.schema, &held.scene));
                now == Some((&before.schema, &before.scene))
            };
            if !self.held.as_ref().is_some_and(same) {
                // Releases the keys that are down in the scene before.
                self.add_gestures(ui, response, eye, &scenes, Wants::default(), &mut gestures);
                self.gestures = Gestures::default();
            }
            self.held = held;
        }
        let wants = match (self.scene(&scenes), &self.held) {
            (Some(scene), Some(held)) => Wants {
                // Drags on the ground turn the view.
                drags: scene.wants.drags && held.shape,
                ..scene.wants
            },
            _ => {
                // The scene is gone, so the end of a drag has no receiver.
                self.gestures = Gestures::default();
                return gestures;
            }
        };
        self.add_gestures(ui, response, eye, &scenes, wants, &mut gestures);
        gestures
    }

    /// Adds the gestures on the current scene.
    fn add_gestures(
        &mut self,
        ui: &Ui,
        response: &Response,
        eye: &Eye,
        scenes: &[Scene<'_>],
        wants: Wants,
        gestures: &mut Vec<(String, Gesture)>,
    ) {
        let Some((scene, held)) = self.scene(scenes).zip(self.held.as_ref()) else {
            return;
        };
        let back = scene.frame.inverse();
        let place = |at: Pos2| {
            let at = position_at_height(eye, screen(response, at), held.at).unwrap_or(held.at);
            let at = back.transform_point3(at);
            [at.x, at.y, at.z].map(f64::from)
        };
        for touch in self.gestures.touches(ui, response, wants, place) {
            let widget = scene.id.to_owned();
            gestures.push((scene.schema.to_owned(), Gesture { widget, touch }));
        }
    }

    fn scene<'a, 's>(&self, scenes: &'s [Scene<'a>]) -> Option<&'s Scene<'a>> {
        let held = self.held.as_ref()?;
        scenes
            .iter()
            .find(|scene| scene.schema == held.schema && scene.id == held.scene)
    }
}

fn screen(response: &Response, at: Pos2) -> Vec2 {
    let at = at - response.rect.min;
    Vec2::new(at.x, at.y)
}

/// The scenes that request gestures and whose frames are known.
fn scenes(seen: &SceneData) -> Vec<Scene<'_>> {
    let mut scenes = Vec::new();
    for (schema, list) in &seen.panels {
        for item in list.walk() {
            if let Item::Scene {
                id,
                frame,
                solids,
                wants,
            } = item
                && *wants != Wants::default()
                && let Some(frame) = seen.frame(frame)
            {
                scenes.push(Scene {
                    schema,
                    id,
                    frame,
                    solids,
                    wants: *wants,
                });
            }
        }
    }
    scenes
}

/// The scene at a point of the screen: that of the nearest shape, or else of the ground, if exactly one scene
/// requests clicks.
fn scene_at(eye: &Eye, screen: Vec2, scenes: &[Scene<'_>]) -> Option<TouchedScene> {
    let held = |scene: &Scene<'_>, at: Vec3, shape: bool| TouchedScene {
        schema: scene.schema.to_owned(),
        scene: scene.id.to_owned(),
        at,
        shape,
    };
    let hits = scenes.iter().flat_map(|scene| {
        let solids = scene.solids.iter();
        solids.filter_map(move |solid| Some((scene, hit::intersect(eye, screen, scene.frame, solid)?)))
    });
    if let Some((scene, (_, at))) = hits.min_by(|(_, one), (_, other)| one.0.total_cmp(&other.0)) {
        return Some(held(scene, at, true));
    }
    let mut clicked = scenes.iter().filter(|scene| scene.wants.clicks);
    let (Some(only), None) = (clicked.next(), clicked.next()) else {
        return None;
    };
    Some(held(only, eye.ray(screen).floor()?, false))
}

/// The position at a point of the screen with the height of another position.
fn position_at_height(eye: &Eye, screen: Vec2, reference: Vec3) -> Option<Vec3> {
    let ray = eye.ray(screen);
    let distance = (reference.z - ray.from.z) / ray.along.z;
    (distance.is_finite() && distance > 0.0 && distance < MAX_DRAG_DISTANCE * eye.distance)
        .then(|| ray.from + ray.along * distance)
}
