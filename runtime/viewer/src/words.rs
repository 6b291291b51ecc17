//! What a viewer may say: a request for a WebSocket, and then short messages. The library's server takes messages of 64 MiB,
//! and would keep as much for each viewer that sends one without its end.

use std::io::Cursor;
use std::net::SocketAddr;

use tungstenite::protocol::frame::FrameHeader;
use tungstenite::protocol::frame::coding::{Data, OpCode};

/// The largest request, bytes.
const HEAD_MAX: usize = 16 << 10;
/// How many headers a request may have.
const HEADERS_MAX: usize = 64;
/// The largest message of a viewer, bytes: it subscribes to channels, at some 30 bytes each.
pub(crate) const MESSAGE_MAX: u64 = 64 << 10;
/// The longest header of a frame, bytes (RFC 6455, section 5.2).
const FRAME_HEADER_MAX: usize = 14;

/// Why a request is not led to the server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unfit {
    /// It is HTTP, but no WebSocket is asked for: somebody has opened the address in a browser.
    NoWebSocket,
    /// It is not HTTP.
    NoHttp,
    TooLong,
}

impl Unfit {
    /// The whole answer to somebody who came to this address.
    pub(crate) fn answer(self, address: SocketAddr) -> String {
        let (status, why) = match self {
            Self::NoWebSocket => ("426 Upgrade Required\r\nupgrade: websocket", "this is not a WebSocket"),
            Self::NoHttp => ("400 Bad Request", "this is not HTTP"),
            Self::TooLong => ("431 Request Header Fields Too Large", "this request is too long"),
        };
        let text = format!(
            "{why}: this port is for Foxglove and Lichtblick; open the connection ws://{address} in one of them. A page for \
             browsers is served with --console.\n"
        );
        format!(
            "HTTP/1.1 {status}\r\nconnection: close\r\ncontent-type: text/plain; charset=utf-8\r\ncontent-length: \
             {}\r\n\r\n{text}",
            text.len()
        )
    }
}

/// Looks at what has come of a request. How long its head is, or `None` if it is not whole.
pub(crate) fn look(read: &[u8]) -> Result<Option<usize>, Unfit> {
    let mut headers = [httparse::EMPTY_HEADER; HEADERS_MAX];
    let mut request = httparse::Request::new(&mut headers);
    match request.parse(read) {
        Ok(httparse::Status::Complete(head)) if head <= HEAD_MAX => {
            let upgrades = |header: &&mut httparse::Header<'_>| {
                header.name.eq_ignore_ascii_case("upgrade") && header.value.eq_ignore_ascii_case(b"websocket")
            };
            let has = request.headers.iter_mut().any(|header| upgrades(&header));
            if has { Ok(Some(head)) } else { Err(Unfit::NoWebSocket) }
        }
        Ok(httparse::Status::Partial) if read.len() <= HEAD_MAX => Ok(None),
        Ok(_) | Err(httparse::Error::TooManyHeaders) => Err(Unfit::TooLong),
        Err(_) => Err(Unfit::NoHttp),
    }
}

/// A viewer's message, or one of its frames, is too large, or is no frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Refused;

/// Follows the frames of a viewer's words.
#[derive(Debug, Default)]
pub(crate) struct Bounds {
    /// What has come of a frame's header.
    header: Vec<u8>,
    /// What is still to come of a frame's payload, bytes.
    left: u64,
    /// What has come of a message, bytes.
    message: u64,
}

impl Bounds {
    /// Looks at the next words. Nothing of them may be passed on if they are refused.
    pub(crate) fn admit(&mut self, mut words: &[u8]) -> Result<(), Refused> {
        while !words.is_empty() {
            if self.left > 0 {
                let now = usize::try_from(self.left).map_or(words.len(), |left| left.min(words.len()));
                words = &words[now..];
                self.left -= now as u64;
                continue;
            }
            self.header.push(words[0]);
            words = &words[1..];
            let mut cursor = Cursor::new(&self.header);
            match FrameHeader::parse(&mut cursor).map_err(|_| Refused)? {
                Some((header, payload)) => {
                    self.header.clear();
                    self.begin(&header, payload)?;
                }
                None if self.header.len() < FRAME_HEADER_MAX => {}
                None => return Err(Refused),
            }
        }
        Ok(())
    }

    fn begin(&mut self, header: &FrameHeader, payload: u64) -> Result<(), Refused> {
        self.left = payload;
        let of_message = match header.opcode {
            OpCode::Data(Data::Continue) => self.message.saturating_add(payload),
            OpCode::Data(Data::Text | Data::Binary | Data::Reserved(_)) => payload,
            // Between the frames of a message there may be others.
            OpCode::Control(_) if payload <= MESSAGE_MAX => return Ok(()),
            OpCode::Control(_) => return Err(Refused),
        };
        self.message = if header.is_final { 0 } else { of_message };
        if of_message > MESSAGE_MAX { Err(Refused) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ASKS: &[u8] = b"GET / HTTP/1.1\r\nHost: 127.0.0.1:8765\r\nConnection: Upgrade\r\nUpgrade: WebSocket\r\n\r\n";

    #[test]
    fn a_request_for_a_web_socket_is_led_on_when_it_is_whole() {
        for whole in 1..ASKS.len() {
            assert_eq!(look(&ASKS[..whole]), Ok(None), "{whole}");
        }
        let more = [ASKS, b"\x81\x80"].concat();
        assert_eq!(look(&more), Ok(Some(ASKS.len())));
    }

    #[test]
    fn what_is_no_such_request_is_answered_in_words() {
        let long = [b"GET /".as_slice(), &[b'x'; HEAD_MAX], b" HTTP/1.1\r\n"].concat();
        let many = format!("GET / HTTP/1.1\r\n{}\r\n", "a: b\r\n".repeat(HEADERS_MAX + 1));
        for (words, unfit, status) in [
            (
                b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n".as_slice(),
                Unfit::NoWebSocket,
                "HTTP/1.1 426 ",
            ),
            (b"\x16\x03\x01\x02\x00\x01\x00", Unfit::NoHttp, "HTTP/1.1 400 "),
            (&long, Unfit::TooLong, "HTTP/1.1 431 "),
            (many.as_bytes(), Unfit::TooLong, "HTTP/1.1 431 "),
        ] {
            assert_eq!(look(words), Err(unfit));
            let answer = unfit.answer("127.0.0.1:8765".parse().unwrap());
            assert!(
                answer.starts_with(status) && answer.contains("ws://127.0.0.1:8765"),
                "{answer}"
            );
            let (head, text) = answer.split_once("\r\n\r\n").unwrap();
            assert!(head.contains(&format!("content-length: {}", text.len())), "{answer}");
        }
    }

    /// A masked frame, as a viewer sends it.
    fn frame(first: u8, payload: usize) -> Vec<u8> {
        let mut frame = vec![first];
        match payload {
            0..=125 => frame.push(0x80 | payload as u8),
            126..=0xffff => {
                frame.push(0x80 | 126);
                frame.extend((payload as u16).to_be_bytes());
            }
            _ => {
                frame.push(0x80 | 127);
                frame.extend((payload as u64).to_be_bytes());
            }
        }
        frame.extend([1, 2, 3, 4]);
        frame.resize(frame.len() + payload, 0);
        frame
    }

    const TEXT: u8 = 0x81;
    const BEGINS: u8 = 0x01;
    const GOES_ON: u8 = 0x00;
    const ENDS: u8 = 0x80;
    const PING: u8 = 0x89;

    #[test]
    fn messages_up_to_the_bound_pass_however_they_are_cut() {
        let most = MESSAGE_MAX as usize;
        let words = [
            frame(TEXT, 0),
            frame(TEXT, 125),
            frame(BEGINS, most / 2),
            frame(PING, 4),
            frame(ENDS, most / 2),
            frame(TEXT, most),
        ]
        .concat();
        for chunk in [1, 7, 4096, words.len()] {
            let mut bounds = Bounds::default();
            assert_eq!(
                words.chunks(chunk).try_for_each(|chunk| bounds.admit(chunk)),
                Ok(()),
                "{chunk}"
            );
        }
    }

    #[test]
    fn a_larger_message_is_refused_before_its_payload_comes_also_in_frames() {
        let most = MESSAGE_MAX as usize;
        assert_eq!(Bounds::default().admit(&frame(TEXT, most + 1)[..14]), Err(Refused));
        let longest = [&[0x81, 0xff][..], &[0xff; 8], &[1, 2, 3, 4]].concat();
        assert_eq!(Bounds::default().admit(&longest), Err(Refused));
        assert_eq!(Bounds::default().admit(&frame(PING, most + 1)[..14]), Err(Refused));
        let mut bounds = Bounds::default();
        assert_eq!(bounds.admit(&frame(BEGINS, most)), Ok(()));
        assert_eq!(bounds.admit(&frame(GOES_ON, 1)), Err(Refused));
    }
}
