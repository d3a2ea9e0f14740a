//! XML as SDF files have it: the subset of XML, and the errors of their writers, that TinyXML2 reads, with which Gazebo
//! reads them. A `--` in a comment, a `&` alone, prefixes that nobody declares and text around the root are read; what is
//! not closed, or closed by another name, is a fault.

use std::fmt;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use jde_files::Budget;
use quick_xml::Reader;
use quick_xml::escape::resolve_predefined_entity;
use quick_xml::events::{BytesRef, BytesStart, Event};

/// Most levels of elements, as TinyXML2 has it.
const MAX_DEPTH: usize = 500;
/// The memory of an element beside its texts: itself, its place among the children of another, and what allocators add.
const ELEMENT: usize = size_of::<Element>() + 64;

/// The roots of SDF files, now and before version 1.3.
pub(super) const ROOTS: [&str; 2] = ["sdf", "gazebo"];
/// The version in which the attribute `frame` of a pose became `relative_to`.
const RELATIVE_TO: [u32; 2] = [1, 7];

/// A line, and what is wrong there.
type Wrong = (usize, String);

/// The elements of a file.
#[derive(Debug)]
pub(super) struct Document {
    /// In the order of their starts; the first has no name and contains the roots.
    elements: Vec<Element>,
    /// The file; none for the one that is converted.
    file: Option<PathBuf>,
    /// The version of SDF that its root states: 0.0 if none.
    version: [u32; 2],
}

#[derive(Debug, Default)]
struct Element {
    name: String,
    attributes: Vec<(String, String)>,
    /// The texts that comments separate, up to the first element within.
    texts: Vec<String>,
    children: Vec<usize>,
    line: usize,
}

/// Where an element is: its line, and its file unless that is the one that is converted.
#[derive(Clone, Debug)]
pub(super) struct ElementPlace {
    pub(super) file: Option<PathBuf>,
    pub(super) line: usize,
}

impl fmt::Display for ElementPlace {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.file {
            Some(file) => write!(formatter, "{}:{}", file.display(), self.line),
            None => write!(formatter, "line {}", self.line),
        }
    }
}

/// An element.
#[derive(Clone, Debug)]
pub(super) struct Node {
    document: Rc<Document>,
    index: usize,
}

impl Document {
    /// Reads a text. `file` is the file that has it, unless it is the one that is converted.
    pub(super) fn parse(text: &str, file: Option<&Path>, budget: &mut Budget) -> Result<Rc<Self>, Wrong> {
        let mut reader = Reader::from_str(text);
        let config = reader.config_mut();
        config.allow_dangling_amp = true;
        config.allow_unmatched_ends = true;
        config.expand_empty_elements = true;
        let mut elements = vec![Element::default()];
        let mut open = vec![0];
        // The text continues: neither a comment nor an element came since.
        let mut continues = false;
        let (mut line, mut counted) = (1, 0);
        loop {
            let position = reader.buffer_position() as usize;
            let passed = text.as_bytes().get(counted..position).unwrap_or_default();
            line += passed.iter().filter(|&&byte| byte == b'\n').count();
            counted = position;
            let fault = |message: String| (line, message);
            let exceeded = |error: jde_files::Exceeded| (line, error.to_string());
            budget.work(1).map_err(exceeded)?;
            let event = match reader.read_event() {
                Ok(event) => event,
                // What follows the root is nobody's.
                Err(_) if open.len() == 1 && elements.len() > 1 => break,
                Err(error) => return Err(fault(format!("it is no XML: {error}"))),
            };
            let Some(&parent) = open.last() else { break };
            let piece = match event {
                Event::Start(start) => {
                    let element = element(&start, line).map_err(fault)?;
                    if open.len() > MAX_DEPTH {
                        return Err(fault(format!(
                            "its elements contain each other more than {MAX_DEPTH} levels deep"
                        )));
                    }
                    let words = element
                        .attributes
                        .iter()
                        .map(|(key, value)| key.len() + value.len() + 64);
                    budget
                        .hold(ELEMENT + element.name.len() + words.sum::<usize>())
                        .map_err(exceeded)?;
                    continues = false;
                    open.push(elements.len());
                    let index = elements.len();
                    elements[parent].children.push(index);
                    elements.push(element);
                    continue;
                }
                Event::End(_) => {
                    // More ends than starts: what follows the root is nobody's.
                    if open.len() > 1 {
                        open.pop();
                    }
                    continues = false;
                    continue;
                }
                Event::Text(text) => String::from_utf8_lossy(&text).into_owned(),
                Event::CData(text) => String::from_utf8_lossy(&text).into_owned(),
                Event::GeneralRef(reference) => resolved(&reference),
                Event::Comment(_) => {
                    continues = false;
                    continue;
                }
                Event::Eof => break,
                Event::Empty(_) | Event::Decl(_) | Event::PI(_) | Event::DocType(_) => continue,
            };
            let element = &mut elements[parent];
            if !element.children.is_empty() || (!continues && piece.trim().is_empty()) {
                continue;
            }
            budget
                .hold(piece.len() + if continues { 0 } else { 64 })
                .map_err(exceeded)?;
            match element.texts.last_mut().filter(|_| continues) {
                Some(text) => text.push_str(&piece),
                None => element.texts.push(piece),
            }
            continues = true;
        }
        match open.last().map(|&index| &elements[index]) {
            Some(element) if open.len() > 1 => {
                Err((element.line, format!("`<{}>` is not closed", element.name)))
            }
            _ => Ok(Rc::new(Self::new(elements, file))),
        }
    }

    fn new(elements: Vec<Element>, file: Option<&Path>) -> Self {
        let versions = elements
            .iter()
            .filter(|element| ROOTS.contains(&element.name.as_str()));
        let mut stated = versions
            .flat_map(|element| &element.attributes)
            .filter(|(key, _)| key == "version");
        let version = stated.next().map(|(_, value)| version(value)).unwrap_or_default();
        Self {
            elements,
            file: file.map(Path::to_owned),
            version,
        }
    }

    /// Returns the first element that is in no other and has one of the names, or else the first of all.
    pub(super) fn root(self: &Rc<Self>, names: &[&str]) -> Option<Node> {
        let node = |&index: &usize| Node {
            document: Rc::clone(self),
            index,
        };
        let roots = &self.elements.first()?.children;
        let named = |index: &&usize| names.contains(&self.elements[**index].name.as_str());
        roots.iter().find(named).or(roots.first()).map(node)
    }
}

impl Node {
    fn element(&self) -> &Element {
        &self.document.elements[self.index]
    }

    pub(super) fn name(&self) -> &str {
        &self.element().name
    }

    pub(super) fn place(&self) -> ElementPlace {
        ElementPlace {
            file: self.document.file.clone(),
            line: self.element().line,
        }
    }

    /// Returns the file that it is in, unless that is the one that is converted.
    pub(super) fn file(&self) -> Option<&Path> {
        self.document.file.as_deref()
    }

    /// Whether a pose of it has the attribute `frame` instead of `relative_to`.
    pub(super) fn is_before_relative_to(&self) -> bool {
        self.document.version < RELATIVE_TO
    }

    /// Returns the attribute; of two of one name, the first.
    pub(super) fn attribute(&self, name: &str) -> Option<&str> {
        let attributes = &self.element().attributes;
        attributes
            .iter()
            .find(|(key, _)| key == name)
            .map(|(_, value)| value.as_str())
    }

    /// Returns the text before the first element within, up to a comment within the text.
    pub(super) fn text(&self) -> &str {
        self.element().texts.first().map_or("", |text| text.trim())
    }

    /// Returns the text before the first element within, without the comments.
    pub(super) fn whole_text(&self) -> String {
        self.element().texts.join(" ")
    }

    pub(super) fn children(&self) -> impl Iterator<Item = Self> {
        self.element().children.iter().map(|&index| Self {
            document: Rc::clone(&self.document),
            index,
        })
    }

    pub(super) fn children_named(&self, name: &str) -> impl Iterator<Item = Self> {
        self.children().filter(move |child| child.name() == name)
    }

    pub(super) fn child(&self, name: &str) -> Option<Self> {
        self.children_named(name).next()
    }
}

/// Returns the parts of a version; what is none is 0.
pub(super) fn version(text: &str) -> [u32; 2] {
    let mut parts = text.trim().split('.').map(|part| part.parse().unwrap_or(0));
    [parts.next().unwrap_or(0), parts.next().unwrap_or(0)]
}

fn element(start: &BytesStart<'_>, line: usize) -> Result<Element, String> {
    let name = String::from_utf8_lossy(start.name().as_ref()).into_owned();
    if name.starts_with('%') {
        return Err(
            "it is a template (ERB): write `erb FILE > NEW.sdf`, and convert the new file".to_owned(),
        );
    }
    let mut attributes = Vec::new();
    for attribute in start.attributes().with_checks(false) {
        let attribute = attribute.map_err(|error| {
            format!("an attribute of `<{name}>` is not of the form name=\"value\": {error}")
        })?;
        let key = String::from_utf8_lossy(attribute.key.as_ref()).into_owned();
        attributes.push((key, unescaped(&String::from_utf8_lossy(&attribute.value))));
    }
    Ok(Element {
        name,
        attributes,
        line,
        ..Element::default()
    })
}

/// Returns the text of a reference; one that is not known stays as it is.
fn resolved(reference: &BytesRef<'_>) -> String {
    let name = String::from_utf8_lossy(reference);
    match reference.resolve_char_ref() {
        Ok(Some(letter)) => letter.to_string(),
        _ => resolve_predefined_entity(&name).map_or_else(|| format!("&{name};"), str::to_owned),
    }
}

/// Resolves the references of an attribute's value.
fn unescaped(value: &str) -> String {
    let mut text = String::with_capacity(value.len());
    let mut rest = value;
    while let Some((before, after)) = rest.split_once('&') {
        text += before;
        match after.split_once(';') {
            Some((name, behind)) if name.len() < 12 => {
                text += &resolved(&BytesRef::new(name));
                rest = behind;
            }
            _ => {
                text.push('&');
                rest = after;
            }
        }
    }
    text + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Node, Wrong> {
        Document::parse(text, None, &mut Budget::default()).map(|document| document.root(&["sdf"]).unwrap())
    }

    fn fault(text: &str) -> Wrong {
        parse(text).expect_err("it is no XML")
    }

    #[test]
    fn what_tinyxml2_reads_is_read() {
        let text = |file: &str| {
            parse(file)
                .unwrap_or_else(|fault| panic!("{file}: {fault:?}"))
                .text()
                .to_owned()
        };
        for (file, right) in [
            ("<sdf><!-- a -- b --><!-- c ---> 1 </sdf>", "1"),
            ("<sdf>1 <!-- 2 --> 3</sdf>", "1"),
            ("<sdf> <!-- --> <!-- --> 2 3</sdf>", "2 3"),
            ("<sdf><![CDATA[1 2]]> </sdf>", "1 2"),
            ("<sdf>a & b &foo; &lt;&#65;&#x42;</sdf>", "a & b &foo; <AB"),
            (
                "<?xml version='1.0' encoding='latin-1'?>\n<!DOCTYPE sdf [ <!ENTITY e 'x'> ]><sdf>&e;</sdf>",
                "&e;",
            ),
            ("text <sdf>1</sdf> garbage <c/>", "1"),
            ("<sdf>1</sdf></b>", "1"),
            ("<a/><sdf>1 > 2</sdf >", "1 > 2"),
            ("<?foo bar?><!-- --><sdf>1</sdf><", "1"),
            ("<sdf><b/>1</sdf>", ""),
        ] {
            assert_eq!(text(file), right, "{file}");
        }
        let node = parse("<sdf a = '1<2>'b=\"x&amp;y & z\" gz:c='&quot;' a='2'><gz::x/></sdf>").unwrap();
        let values = ["a", "b", "gz:c", "d"].map(|name| node.attribute(name));
        assert_eq!(values, [Some("1<2>"), Some("x&y & z"), Some("\""), None]);
        assert_eq!(node.children().next().unwrap().name(), "gz::x");
    }

    #[test]
    fn what_it_refuses_is_refused_with_its_line() {
        assert_eq!(fault("<sdf>\r\n<b>\n\n"), (2, "`<b>` is not closed".to_owned()));
        for file in [
            "<sdf>\n<b></c>\n</sdf>",
            "<sdf>\n<b x=1/></sdf>",
            "<sdf>\n<b x/></sdf>",
            "<sdf>\n<!-- ",
        ] {
            let (line, message) = fault(file);
            assert_eq!(line, 2, "{file}: {message}");
        }
        assert!(
            Document::parse("", None, &mut Budget::default())
                .unwrap()
                .root(&["sdf"])
                .is_none()
        );
    }

    #[test]
    fn depth_memory_and_work_are_limited() {
        let (_, message) = fault(&"<sdf>".repeat(20_000));
        assert_eq!(
            message,
            "its elements contain each other more than 500 levels deep"
        );
        let wide = format!("<sdf>{}</sdf>", "<a b='1' c='2'/>".repeat(1000));
        assert!(Document::parse(&wide, None, &mut Budget::new(100_000, 1_000_000, 8)).is_err());
        assert!(Document::parse(&wide, None, &mut Budget::new(1 << 30, 1000, 8)).is_err());
        assert!(Document::parse(&wide, None, &mut Budget::default()).is_ok());
    }
}
