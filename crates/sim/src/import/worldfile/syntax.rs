//! The syntax of Stage's world files: words, numbers, texts, tuples in brackets, entities in parentheses,
//! `define` and `include`. It knows no entity.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use crate::error::Fault;

/// Most entities of a world, with those that definitions repeat.
const MAX_ENTITIES: usize = 100_000;
/// The greatest depth of files that include others, and of entities within entities.
const MAX_DEPTH: usize = 32;

/// A place in a file.
#[derive(Clone, Debug)]
pub(super) struct Place {
    file: Rc<Path>,
    line: usize,
}

/// An entity, with all that its definition says.
#[derive(Clone, Debug)]
pub(super) struct Entity {
    /// Its own type, such as `pioneer2dx`.
    pub(super) kind: String,
    /// The type of Stage's own that its definition leads to.
    pub(super) base: String,
    pub(super) place: Place,
    properties: Vec<(String, Value)>,
    pub(super) children: Vec<Entity>,
    /// Number of entities, and of levels: itself and all below.
    size: usize,
    depth: usize,
}

#[derive(Clone, Debug)]
enum Value {
    Text(String, Place),
    Numbers(Vec<f64>, Place),
}

#[derive(Clone, Debug, PartialEq)]
enum Token {
    Word(String),
    Text(String),
    Number(f64),
    Open,
    Close,
    OpenTuple,
    CloseTuple,
}

/// Returns the outermost entity of a file: its properties, and its entities.
///
/// # Errors
/// The first fault of the file, or of one that it includes.
pub(super) fn parse(path: &Path, text: &str) -> Result<Entity, Fault> {
    let mut tokens = Vec::new();
    read_tokens(path, text, 0, &mut tokens)?;
    let start = Place {
        file: path.into(),
        line: 1,
    };
    let mut parser = Parser {
        tokens,
        next: 0,
        definitions: HashMap::new(),
    };
    let mut root = Entity::new("world", start);
    parser.body(&mut root, 0)?;
    Ok(root)
}

impl Place {
    /// Returns a fault at this place.
    pub(super) fn fault(&self, message: impl Into<String>) -> Fault {
        Fault {
            file: self.file.to_path_buf(),
            line: Some(self.line),
            message: message.into(),
        }
    }
}

impl Entity {
    fn new(base: &str, place: Place) -> Self {
        Self {
            kind: base.to_owned(),
            base: base.to_owned(),
            place,
            properties: Vec::new(),
            children: Vec::new(),
            size: 1,
            depth: 1,
        }
    }

    /// Returns a text. A later property replaces an earlier one of the same name, such as that of the
    /// definition.
    pub(super) fn text(&self, key: &str) -> Option<&str> {
        match self.value(key)? {
            Value::Text(text, _) => Some(text),
            Value::Numbers(..) => None,
        }
    }

    /// Returns the path of a file that a property names: relative to the file with the property.
    pub(super) fn path(&self, key: &str) -> Option<(PathBuf, &Place)> {
        match self.value(key)? {
            Value::Text(text, place) => Some((beside(&place.file, text), place)),
            Value::Numbers(..) => None,
        }
    }

    /// Returns numbers.
    ///
    /// # Errors
    /// If the property is no list of so many finite numbers.
    pub(super) fn numbers(
        &self,
        key: &str,
        count: core::ops::RangeInclusive<usize>,
    ) -> Result<Option<&[f64]>, Fault> {
        let (numbers, place) = match self.value(key) {
            None => return Ok(None),
            Some(Value::Numbers(numbers, place)) => (&numbers[..], place),
            Some(Value::Text(_, place)) => (&[][..], place),
        };
        if count.contains(&numbers.len()) && numbers.iter().all(|number| number.is_finite()) {
            return Ok(Some(numbers));
        }
        Err(place.fault(format!("`{key}` is wrong: expected {} numbers", count.end())))
    }

    /// Returns whether a property is a number below or above 0; `default` if it is missing.
    pub(super) fn is_positive(&self, key: &str, default: bool) -> Result<bool, Fault> {
        let number = self.numbers(key, 1..=1)?;
        Ok(number.map_or(default, |number| number[0] > 0.0))
    }

    fn value(&self, key: &str) -> Option<&Value> {
        let mut latest_first = self.properties.iter().rev();
        latest_first.find(|(name, _)| name == key).map(|(_, value)| value)
    }
}

struct Parser {
    tokens: Vec<(Token, Place)>,
    next: usize,
    definitions: HashMap<String, Entity>,
}

impl Parser {
    fn take(&mut self) -> Option<(Token, Place)> {
        let token = self.tokens.get(self.next).cloned();
        self.next += 1;
        token
    }

    fn is_next(&self, token: &Token) -> bool {
        self.tokens.get(self.next).is_some_and(|(next, _)| next == token)
    }

    /// Reads properties and entities into an entity, up to its end.
    fn body(&mut self, entity: &mut Entity, depth: usize) -> Result<(), Fault> {
        while let Some((token, place)) = self.take() {
            match token {
                Token::Close if depth > 0 => return Ok(()),
                Token::Word(word) if word == "define" => self.define(&place)?,
                Token::Word(word) if self.is_next(&Token::Open) => {
                    let child = self.entity(&word, place.clone(), depth)?;
                    entity.size += child.size;
                    entity.depth = entity.depth.max(child.depth + 1);
                    if entity.size > MAX_ENTITIES || entity.depth > MAX_DEPTH {
                        let message = format!(
                            "has more than {MAX_ENTITIES} entities, or more than {MAX_DEPTH} levels of them"
                        );
                        return Err(place.fault(message));
                    }
                    entity.children.push(child);
                }
                Token::Word(word) => self.property(entity, word, place)?,
                token => return Err(place.fault(format!("{token} is not expected here: a word is"))),
            }
        }
        if depth == 0 {
            Ok(())
        } else {
            Err(entity.place.fault("has no `)` at its end"))
        }
    }

    fn define(&mut self, place: &Place) -> Result<(), Fault> {
        let (name, base) = (self.take(), self.take());
        let (Some((Token::Word(name), _)), Some((Token::Word(base), _))) = (name, base) else {
            return Err(place.fault("`define` needs a new name, a known one and `(`"));
        };
        if !self.is_next(&Token::Open) {
            return Err(place.fault("`define` needs a new name, a known one and `(`"));
        }
        let definition = self.entity(&base, place.clone(), 0)?;
        self.definitions.insert(name, definition);
        Ok(())
    }

    /// Reads an entity from its `(` to its `)`.
    fn entity(&mut self, kind: &str, place: Place, depth: usize) -> Result<Entity, Fault> {
        if depth >= MAX_DEPTH {
            return Err(place.fault(format!("has more than {MAX_DEPTH} levels of entities")));
        }
        let definition = self.definitions.get(kind).cloned();
        let mut entity = definition.unwrap_or_else(|| Entity::new(kind, place.clone()));
        (entity.kind, entity.place) = (kind.to_owned(), place);
        self.take();
        self.body(&mut entity, depth + 1)?;
        Ok(entity)
    }

    fn property(&mut self, entity: &mut Entity, name: String, place: Place) -> Result<(), Fault> {
        let mut numbers = Vec::new();
        let mut in_tuple = false;
        while let Some((token, _)) = self.tokens.get(self.next) {
            match token {
                Token::Number(number) => numbers.push(*number),
                Token::Text(text) => {
                    let value = Value::Text(text.clone(), place.clone());
                    entity.properties.push((name.clone(), value));
                }
                Token::OpenTuple if !in_tuple => in_tuple = true,
                Token::CloseTuple if in_tuple => in_tuple = false,
                Token::Word(_) if in_tuple => {}
                _ => break,
            }
            self.next += 1;
        }
        if in_tuple {
            return Err(place.fault(format!("`{name}` has no `]` at its end")));
        }
        if !numbers.is_empty() {
            entity.properties.push((name, Value::Numbers(numbers, place)));
        }
        Ok(())
    }
}

/// As it is written.
impl core::fmt::Display for Token {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Word(word) => write!(f, "`{word}`"),
            Self::Text(text) => write!(f, "{text:?}"),
            Self::Number(number) => write!(f, "{number}"),
            Self::Open => write!(f, "`(`"),
            Self::Close => write!(f, "`)`"),
            Self::OpenTuple => write!(f, "`[`"),
            Self::CloseTuple => write!(f, "`]`"),
        }
    }
}

/// Appends the tokens of a file, and those of the files that it includes in their place.
fn read_tokens(path: &Path, text: &str, depth: usize, tokens: &mut Vec<(Token, Place)>) -> Result<(), Fault> {
    let file: Rc<Path> = path.into();
    for (line, text) in (1..).zip(text.lines()) {
        let place = Place {
            file: file.clone(),
            line,
        };
        let mut rest = text.trim_start();
        let mut is_include = false;
        while let Some(first) = rest.chars().next().filter(|first| *first != '#') {
            let (token, length) = token(rest, first).map_err(|message| place.fault(message))?;
            rest = rest[length..].trim_start();
            match token {
                Token::Text(name) if is_include => include(path, &name, &place, depth, tokens)?,
                _ if is_include => return Err(place.fault("`include` needs the name of a file in quotes")),
                Token::Word(word) if word == "include" => {
                    is_include = true;
                    continue;
                }
                token => tokens.push((token, place.clone())),
            }
            is_include = false;
        }
        if is_include {
            return Err(place.fault("`include` needs the name of a file in quotes"));
        }
    }
    Ok(())
}

fn include(
    path: &Path,
    name: &str,
    place: &Place,
    depth: usize,
    tokens: &mut Vec<(Token, Place)>,
) -> Result<(), Fault> {
    if depth >= MAX_DEPTH {
        return Err(place.fault(format!("more than {MAX_DEPTH} files include each other")));
    }
    let file = beside(path, name);
    let text = jde_files::read_text(&file, jde_map_file::MAX_TEXT)
        .map_err(|error| place.fault(format!("cannot read `{}`: {error}", file.display())))?;
    read_tokens(&file, &text, depth + 1, tokens)
}

/// Returns a file named in another one.
fn beside(path: &Path, name: &str) -> PathBuf {
    path.parent().unwrap_or(Path::new("")).join(name)
}

/// Returns the token at the start of a text that begins with `first`, and its length in bytes.
fn token(text: &str, first: char) -> Result<(Token, usize), String> {
    let single = match first {
        '(' => Some(Token::Open),
        ')' => Some(Token::Close),
        '[' => Some(Token::OpenTuple),
        ']' => Some(Token::CloseTuple),
        _ => None,
    };
    if let Some(token) = single {
        return Ok((token, 1));
    }
    let length = |is_part: fn(char) -> bool| text.find(|next| !is_part(next)).unwrap_or(text.len());
    if first == '"' {
        let end = text[1..]
            .find('"')
            .ok_or("a text has no `\"` at its end on this line")?;
        return Ok((Token::Text(text[1..=end].to_owned()), end + 2));
    }
    if first.is_ascii_alphabetic() {
        // The index of a word, as in `point[0]`, belongs to it.
        let length =
            length(|next| next.is_ascii_alphanumeric() || matches!(next, '_' | '-' | '.' | '[' | ']'));
        return Ok((Token::Word(text[..length].to_owned()), length));
    }
    let length = length(|next| next.is_ascii_alphanumeric() || matches!(next, '+' | '-' | '.'));
    match text[..length].parse() {
        Ok(number) => Ok((Token::Number(number), length)),
        Err(_) => Err(format!(
            "`{}` is no number",
            text[..length.max(first.len_utf8())].escape_debug()
        )),
    }
}
