//! The syntax of Stage's world files (`worldfile.cc` of Stage 4.3): words, numbers, texts, tuples in brackets, entities in
//! parentheses, `define` and `include`. It knows no entity.
//!
//! As in Stage, a definition is read where it is used, so that it may use later ones, the first of two with one name
//! counts, and files are named relative to the world or else to the file that names them.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use jde_document::{Fault, MAX_BYTES};
use jde_files::{Budget, Exceeded, LeftOut};

/// The greatest depth of files that include others, of definitions that use others, and of entities within entities.
const MAX_DEPTH: usize = 64;

/// A place in a file.
#[derive(Clone, Debug)]
pub(super) struct TokenPlace {
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
    pub(super) place: TokenPlace,
    properties: Vec<(String, Value)>,
    pub(super) children: Vec<Entity>,
}

#[derive(Clone, Debug)]
enum Value {
    Text(String, TokenPlace),
    Numbers(Vec<f64>, TokenPlace),
}

/// A definition: where its entity begins, and the type of that.
#[derive(Clone, Debug)]
struct Definition {
    base: String,
    /// The number of the token `(`.
    start: usize,
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
pub(super) fn parse(
    path: &Path,
    text: &str,
    budget: &mut Budget,
    left_out: &mut LeftOut,
) -> Result<Entity, Fault> {
    let start = TokenPlace {
        file: path.into(),
        line: 1,
    };
    let mut parser = Parser {
        tokens: Vec::new(),
        next: 0,
        definitions: HashMap::new(),
        budget,
        left_out,
    };
    parser.read_tokens(path, path, text, 0)?;
    let mut root = Entity::new("world", start);
    parser.body(&mut root, 0)?;
    Ok(root)
}

impl TokenPlace {
    /// Returns a fault at this place.
    pub(super) fn fault(&self, message: impl Into<String>) -> Fault {
        Fault::at_line(&self.file, self.line, message)
    }

    /// Returns a file that is named here: beside the world, as in Stage, or else beside the file that names it.
    fn named(&self, world: &Path, name: &str) -> PathBuf {
        let folder = |path: &Path| path.parent().unwrap_or(Path::new("")).join(name);
        Some(folder(world))
            .filter(|path| path.is_file())
            .unwrap_or_else(|| folder(&self.file))
    }
}

/// As in a report: the file and the line.
impl core::fmt::Display for TokenPlace {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let name = self.file.file_name().unwrap_or_default().to_string_lossy();
        write!(f, "{name}:{}", self.line)
    }
}

impl Entity {
    fn new(base: &str, place: TokenPlace) -> Self {
        Self {
            kind: base.to_owned(),
            base: base.to_owned(),
            place,
            properties: Vec::new(),
            children: Vec::new(),
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

    /// Whether a property is stated.
    pub(super) fn has(&self, key: &str) -> bool {
        self.value(key).is_some()
    }

    /// Returns the path of a file that a property names.
    pub(super) fn path(&self, key: &str, world: &Path) -> Option<(PathBuf, &TokenPlace)> {
        match self.value(key)? {
            Value::Text(text, place) => Some((place.named(world, text), place)),
            Value::Numbers(..) => None,
        }
    }

    /// Returns the names of all properties, and where they are stated.
    pub(super) fn keys(&self) -> impl Iterator<Item = (&str, &TokenPlace)> {
        self.properties.iter().map(|(name, value)| {
            let (Value::Text(_, place) | Value::Numbers(_, place)) = value;
            (name.as_str(), place)
        })
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

struct Parser<'p> {
    tokens: Vec<(Token, TokenPlace)>,
    next: usize,
    definitions: HashMap<String, Definition>,
    budget: &'p mut Budget,
    left_out: &'p mut LeftOut,
}

impl Parser<'_> {
    fn take(&mut self) -> Option<(Token, TokenPlace)> {
        let token = self.tokens.get(self.next).cloned();
        self.next += 1;
        token
    }

    fn is_next(&self, token: &Token) -> bool {
        self.tokens.get(self.next).is_some_and(|(next, _)| next == token)
    }

    /// Counts what is read, and what is kept of it.
    fn count(&mut self, place: &TokenPlace, bytes: usize) -> Result<(), Fault> {
        let counted = self.budget.work(1).and_then(|()| self.budget.hold(bytes));
        counted.map_err(|exceeded| refused(place, exceeded))
    }

    /// Reads properties and entities into an entity, up to its end.
    fn body(&mut self, entity: &mut Entity, depth: usize) -> Result<(), Fault> {
        while let Some((token, place)) = self.take() {
            match token {
                Token::Close if depth > 0 => return Ok(()),
                Token::Word(word) if word == "define" => self.define(&place)?,
                Token::Word(word) if self.is_next(&Token::Open) => {
                    let child = self.entity(&word, place, depth)?;
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

    /// Remembers where a definition is, up to its end.
    fn define(&mut self, place: &TokenPlace) -> Result<(), Fault> {
        let (name, base) = (self.take(), self.take());
        let (Some((Token::Word(name), _)), Some((Token::Word(base), _))) = (name, base) else {
            return Err(place.fault("`define` needs a new name, a known one and `(`"));
        };
        let start = self.next;
        if !self.is_next(&Token::Open) {
            return Err(place.fault("`define` needs a new name, a known one and `(`"));
        }
        let mut depth = 0_usize;
        loop {
            match self.take() {
                Some((Token::Open, _)) => depth += 1,
                Some((Token::Close, _)) => depth -= 1,
                Some((Token::Word(_) | Token::Text(_) | Token::Number(_), _)) => {}
                Some((Token::OpenTuple | Token::CloseTuple, _)) => {}
                None => return Err(place.fault(format!("the definition of `{name}` has no `)` at its end"))),
            }
            if depth == 0 {
                break;
            }
        }
        self.count(place, size_of::<Definition>() + name.len() + base.len())?;
        match self.definitions.entry(name) {
            Entry::Vacant(free) => {
                free.insert(Definition { base, start });
            }
            Entry::Occupied(first) => {
                let what = format!("the second definition of `{}`", first.key());
                let why = "the first one counts, as in Stage";
                self.left_out.add(what, Some(place), why);
            }
        }
        Ok(())
    }

    /// Reads an entity from its `(` to its `)`.
    fn entity(&mut self, kind: &str, place: TokenPlace, depth: usize) -> Result<Entity, Fault> {
        if depth >= MAX_DEPTH {
            let message = format!("has more than {MAX_DEPTH} levels of entities or definitions");
            return Err(place.fault(message));
        }
        self.count(&place, 2 * (size_of::<Entity>() + kind.len()))?;
        let mut entity = match self.definitions.get(kind).cloned() {
            None => Entity::new(kind, place.clone()),
            Some(Definition { base, start }) => {
                let back = core::mem::replace(&mut self.next, start);
                let entity = self.entity(&base, place.clone(), depth + 1)?;
                self.next = back;
                entity
            }
        };
        (entity.kind, entity.place) = (kind.to_owned(), place);
        self.take();
        self.body(&mut entity, depth + 1)?;
        Ok(entity)
    }

    fn property(&mut self, entity: &mut Entity, name: String, place: TokenPlace) -> Result<(), Fault> {
        let mut numbers = Vec::new();
        let mut in_tuple = false;
        while let Some((token, _)) = self.tokens.get(self.next) {
            let mut held = size_of::<f64>();
            match token {
                Token::Number(number) => numbers.push(*number),
                Token::Text(text) => {
                    held += text.len();
                    let value = Value::Text(text.clone(), place.clone());
                    entity.properties.push((name.clone(), value));
                }
                Token::OpenTuple if !in_tuple => in_tuple = true,
                Token::CloseTuple if in_tuple => in_tuple = false,
                Token::Word(_) if in_tuple => {}
                _ => break,
            }
            self.count(&place, held)?;
            self.next += 1;
        }
        if in_tuple {
            return Err(place.fault(format!("`{name}` has no `]` at its end")));
        }
        self.count(&place, size_of::<(String, Value)>() + name.len())?;
        if !numbers.is_empty() {
            entity.properties.push((name, Value::Numbers(numbers, place)));
        }
        Ok(())
    }

    /// Appends the tokens of a file, and those of the files that it includes in their place.
    fn read_tokens(&mut self, world: &Path, path: &Path, text: &str, depth: usize) -> Result<(), Fault> {
        let file: Rc<Path> = path.into();
        // Stage ends lines as any system does.
        let lines = text
            .split('\n')
            .flat_map(|line| line.strip_suffix('\r').unwrap_or(line).split('\r'));
        for (line, text) in (1..).zip(lines) {
            let place = TokenPlace {
                file: file.clone(),
                line,
            };
            let mut rest = text.trim_start();
            let mut is_include = false;
            while let Some(first) = rest.chars().next().filter(|first| *first != '#') {
                let (token, length) = token(rest, first).map_err(|message| place.fault(message))?;
                rest = rest[length..].trim_start();
                self.count(&place, size_of::<(Token, TokenPlace)>() + length)?;
                match token {
                    Token::Text(name) if is_include => self.include(world, &name, &place, depth)?,
                    _ if is_include => {
                        return Err(place.fault("`include` needs the name of a file in quotes"));
                    }
                    Token::Word(word) if word == "include" => {
                        is_include = true;
                        continue;
                    }
                    token => self.tokens.push((token, place.clone())),
                }
                is_include = false;
            }
            if is_include {
                return Err(place.fault("`include` needs the name of a file in quotes"));
            }
        }
        Ok(())
    }

    fn include(&mut self, world: &Path, name: &str, place: &TokenPlace, depth: usize) -> Result<(), Fault> {
        if depth >= MAX_DEPTH {
            return Err(place.fault(format!("more than {MAX_DEPTH} files include each other")));
        }
        let file = place.named(world, name);
        let bytes = jde_files::read_unpacked(&file, MAX_BYTES)
            .map_err(|error| place.fault(format!("cannot read `{}`: {error}", file.display())))?;
        // A file is read each time that it is included: what it takes counts as often.
        self.count(place, bytes.len())?;
        self.read_tokens(world, &file, &String::from_utf8_lossy(&bytes), depth + 1)
    }
}

fn refused(place: &TokenPlace, exceeded: Exceeded) -> Fault {
    place.fault(format!(
        "the world is too large with its definitions and included files: {exceeded}"
    ))
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
            "`{}` is not a number",
            text[..length.max(first.len_utf8())].escape_debug()
        )),
    }
}
