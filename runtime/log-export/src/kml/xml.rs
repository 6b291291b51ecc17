use std::io::{self, Write};

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, BytesText, Event};

/// Writes elements with an indent.
pub(super) struct Xml<W: Write> {
    writer: Writer<W>,
}

impl<W: Write> Xml<W> {
    pub(super) fn new(inner: W) -> Self {
        Self {
            writer: Writer::new_with_indent(inner, b' ', 1),
        }
    }

    pub(super) fn into_inner(self) -> W {
        self.writer.into_inner()
    }

    pub(super) fn declaration(&mut self) -> io::Result<()> {
        self.writer
            .write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))
    }

    /// An element with others in it.
    pub(super) fn within(
        &mut self,
        name: &str,
        attributes: &[(&str, &str)],
        inner: impl FnOnce(&mut Self) -> io::Result<()>,
    ) -> io::Result<()> {
        let attributes: Vec<(String, String)> = attributes
            .iter()
            .map(|(name, value)| ((*name).to_owned(), allowed(value)))
            .collect();
        let attributes = attributes.iter().map(|(name, value)| (name.as_str(), value.as_str()));
        let start = BytesStart::new(name).with_attributes(attributes);
        self.writer.write_event(Event::Start(start))?;
        inner(self)?;
        self.writer.write_event(Event::End(BytesEnd::new(name)))
    }

    /// An element with a text.
    pub(super) fn text(&mut self, name: &str, text: &str) -> io::Result<()> {
        let text = allowed(text);
        self.writer.write_event(Event::Start(BytesStart::new(name)))?;
        self.writer.write_event(Event::Text(BytesText::new(&text)))?;
        self.writer.write_event(Event::End(BytesEnd::new(name)))
    }
}

/// A text without the characters that XML 1.0 cannot have, not even escaped.
fn allowed(text: &str) -> String {
    text.replace(
        |character: char| {
            (character < ' ' && !matches!(character, '\n' | '\t')) || matches!(character, '\u{fffe}' | '\u{ffff}')
        },
        " ",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_and_attributes_are_escaped_and_what_xml_lacks_is_a_blank() {
        let mut xml = Xml::new(Vec::new());
        xml.within("a", &[("b", "\"<\u{1}>")], |xml| xml.text("c", "1 < 2 & \u{0}\u{ffff}"))
            .unwrap();
        assert_eq!(
            String::from_utf8(xml.into_inner()).unwrap(),
            "<a b=\"&quot;&lt; &gt;\">\n <c>1 &lt; 2 &amp;   </c>\n</a>"
        );
    }
}
