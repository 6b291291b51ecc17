//! Reads XML as a tree of elements with their lines. It reads no more of XML than placemarks need.

use quick_xml::Reader;
use quick_xml::escape::resolve_predefined_entity;
use quick_xml::events::{BytesStart, Event};

use super::properties::shortened;
use crate::error::FenceError;

/// Deeper documents are refused, because no placemark lies so deep.
const DEPTH_MAX: usize = 64;

/// An element, without its namespace.
#[derive(Debug, Default)]
pub(super) struct Element {
    pub(super) name: String,
    /// The line where it begins, from 1.
    pub(super) line: usize,
    /// The attribute `name`.
    pub(super) name_attribute: Option<String>,
    /// All text directly in the element.
    pub(super) text: String,
    pub(super) children: Vec<Element>,
}

/// Parses a document and returns its root element.
pub(super) fn parse(text: &str) -> Result<Element, FenceError> {
    let forbidden = |char: char| char < ' ' && !matches!(char, '\t' | '\n' | '\r');
    if let Some((at, char)) = text.char_indices().find(|(_, char)| forbidden(*char)) {
        let line = text[..at].matches('\n').count() + 1;
        let message = format!("control character U+{:04X}", u32::from(char));
        return Err(FenceError::Xml { line, message });
    }
    let mut reader = Reader::from_str(text.strip_prefix('\u{feff}').unwrap_or(text));
    reader.config_mut().expand_empty_elements = true;
    let mut lines = Lines::new(text);
    let mut open: Vec<Element> = Vec::new();
    let mut root = None;
    loop {
        let line = lines.at(reader.buffer_position());
        let bad = |message: String| Err(FenceError::Xml { line, message });
        let event = match reader.read_event() {
            Ok(event) => event,
            Err(error) => {
                let line = lines.at(reader.error_position());
                let message = shortened(&error.to_string().replace('\n', " "));
                return Err(FenceError::Xml { line, message });
            }
        };
        match event {
            Event::Start(start) | Event::Empty(start) => {
                if root.is_some() {
                    return bad("a second root element".to_owned());
                }
                if open.len() == DEPTH_MAX {
                    return bad(format!("elements nested over {DEPTH_MAX} deep"));
                }
                open.push(element(&start, line)?);
            }
            Event::End(_) => {
                // The reader has checked that it matches.
                let Some(closed) = open.pop() else {
                    return bad("an end tag without a start tag".to_owned());
                };
                match open.last_mut() {
                    Some(parent) => parent.children.push(closed),
                    None => root = Some(closed),
                }
            }
            Event::Text(text) => write(&mut open, &text.xml10_content(), line)?,
            Event::CData(text) => write(&mut open, &text.xml10_content(), line)?,
            Event::GeneralRef(reference) => match reference.resolve_char_ref() {
                Ok(Some(char)) => write(&mut open, char.encode_utf8(&mut [0; 4]), line)?,
                Ok(None) => match resolve_predefined_entity(&reference) {
                    Some(text) => write(&mut open, text, line)?,
                    None => return bad(format!("unknown entity `{}`", shortened(&reference))),
                },
                Err(error) => return bad(shortened(&error.to_string())),
            },
            // A document's own entities could grow without bound.
            Event::DocType(_) => return bad("a document type definition".to_owned()),
            Event::Comment(_) | Event::Decl(_) | Event::PI(_) => {}
            Event::Eof => break,
        }
    }
    if let Some(unclosed) = open.last() {
        let (line, message) = (unclosed.line, format!("<{}> is not closed", shortened(&unclosed.name)));
        return Err(FenceError::Xml { line, message });
    }
    root.ok_or_else(|| FenceError::Xml {
        line: 1,
        message: "no element".to_owned(),
    })
}

fn element(start: &BytesStart<'_>, line: usize) -> Result<Element, FenceError> {
    let mut element = Element {
        name: start.local_name().as_ref().to_owned(),
        line,
        ..Element::default()
    };
    for attribute in start.attributes() {
        let attribute = attribute.map_err(|error| FenceError::Xml {
            line,
            message: shortened(&error.to_string()),
        })?;
        if attribute.key.as_ref() == "name" {
            element.name_attribute = Some(attribute.value.trim().to_owned());
        }
    }
    Ok(element)
}

fn write(open: &mut [Element], text: &str, line: usize) -> Result<(), FenceError> {
    match (open.last_mut(), text.split_whitespace().next()) {
        (Some(element), _) => element.text.push_str(text),
        (None, None) => {}
        (None, Some(word)) => {
            let blank = &text[..text.len() - text.trim_start().len()];
            return Err(FenceError::Xml {
                line: line + blank.matches('\n').count(),
                message: format!("text `{}` outside the root element", shortened(word)),
            });
        }
    }
    Ok(())
}

/// Counts lines, each once, because positions only grow.
struct Lines<'a> {
    bytes: &'a [u8],
    seen: usize,
    line: usize,
}

impl<'a> Lines<'a> {
    fn new(text: &'a str) -> Self {
        let bytes = text.strip_prefix('\u{feff}').unwrap_or(text).as_bytes();
        Self {
            bytes,
            seen: 0,
            line: 1,
        }
    }

    fn at(&mut self, position: u64) -> usize {
        let end = usize::try_from(position).unwrap_or(usize::MAX).min(self.bytes.len());
        if end > self.seen {
            let passed = self.bytes[self.seen..end].iter();
            self.line += passed.filter(|byte| **byte == b'\n').count();
            self.seen = end;
        }
        self.line
    }
}
