//! The list of what the packages contain (SBOM), in the form of CycloneDX: the libraries that are built in, their licences, and
//! which needs which.

use serde_json::{Value, json};

use crate::metadata::{Metadata, Package};
use crate::tidy::licences::shipped;

/// Returns the list. `time` is that of the last commit.
pub(super) fn list(metadata: &Metadata, version: &str, time: &str) -> Value {
    let (packages, shipped) = (metadata.by_id(), shipped(metadata));
    let reference = |package: &Package| format!("pkg:cargo/{}@{}", package.name, package.version);
    let mut contained: Vec<_> = shipped.iter().filter_map(|id| packages.get(id)).collect();
    contained.sort_by_key(|package| (&package.name, &package.version));
    let components: Vec<Value> = contained
        .iter()
        .map(|package| {
            let mut component = json!({
                "type": "library",
                "bom-ref": reference(package),
                "name": package.name,
                "version": package.version,
                "purl": reference(package),
            });
            if let Some(licence) = &package.license {
                // An older notation of `OR`.
                component["licenses"] = json!([{ "expression": licence.replace('/', " OR ") }]);
            }
            component
        })
        .collect();
    let nodes = metadata.resolve.iter().flat_map(|resolve| &resolve.nodes);
    let dependencies: Vec<Value> = nodes
        .filter(|node| shipped.contains(node.id.as_str()))
        .map(|node| {
            let needed = node
                .deps
                .iter()
                .filter(|edge| edge.dep_kinds.iter().any(|kind| kind.kind.is_none()));
            let needed = needed.filter_map(|edge| packages.get(edge.pkg.as_str()));
            json!({
                "ref": packages.get(node.id.as_str()).map(|package| reference(package)),
                "dependsOn": needed.map(|package| reference(package)).collect::<Vec<_>>(),
            })
        })
        .collect();
    json!({
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "metadata": {
            "timestamp": time,
            "component": { "type": "application", "bom-ref": "jde", "name": "jde", "version": version },
        },
        "components": components,
        "dependencies": dependencies,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_names_what_is_built_in_with_its_licence_and_nothing_of_the_tests() {
        let metadata = Metadata::with_dependencies(&crate::root()).unwrap();
        let list = list(&metadata, "0.1.0", "2026-12-01T00:00:00Z");
        let components = list["components"].as_array().unwrap();
        let named = |name: &str| components.iter().find(|component| component["name"] == name);
        assert_eq!(
            named("serde").unwrap()["licenses"][0]["expression"],
            "MIT OR Apache-2.0"
        );
        assert!(named("jde-core").is_some());
        assert!(named("proptest").is_none() && named("xtask").is_none());
        let refs: Vec<_> = components.iter().map(|component| &component["bom-ref"]).collect();
        for dependency in list["dependencies"].as_array().unwrap() {
            for needed in dependency["dependsOn"].as_array().unwrap() {
                assert!(refs.contains(&needed), "{needed} is needed and not listed");
            }
        }
    }
}
