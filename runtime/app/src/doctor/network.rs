//! The vehicle and the payload controller, and the vehicle's clock by NTP (SPI 2).

use std::io::Read as _;
use std::net::{SocketAddr, TcpStream, ToSocketAddrs as _, UdpSocket};
use std::time::Duration;

use super::{Finding, Word};
use crate::clock::Clock;

/// Nothing on a vehicle's network takes longer.
const WITHIN: Duration = Duration::from_secs(2);
/// How long something at the vehicle's address may take to say who it is.
const UNASKED: Duration = Duration::from_millis(500);
/// Clocks that are further apart close zones with a time window.
const APART_BAD_S: f64 = 60.0;
/// Clocks that are further apart than this are worth a look.
const APART_ODD_S: f64 = 1.0;
/// Seconds from 1900, from which NTP counts, to 1970.
const FROM_1900_S: f64 = 2_208_988_800.0;

/// Whether the vehicle is reached, and how its clock stands to ours.
pub(super) fn vehicle(address: &str) -> Vec<Finding> {
    let reached = reach_vehicle(address);
    let host = address.rsplit_once(':').map_or(address, |(host, _)| host);
    let clock = match ask_time(&format!("{host}:123")) {
        Some(offset_s) => {
            let word = match offset_s.abs() {
                apart if apart > APART_BAD_S => Word::Bad,
                apart if apart > APART_ODD_S => Word::Odd,
                _ => Word::Ok,
            };
            Finding::new(
                "vehicle's clock",
                word,
                format!("{offset_s:+.3} s from ours, by its NTP"),
            )
        }
        None => Finding::new(
            "vehicle's clock",
            Word::Odd,
            format!("{host} does not answer NTP: have something else keep this clock right"),
        ),
    };
    vec![reached, clock]
}

/// Whether somebody listens at an address. The connection is closed at once.
pub(super) fn reach(what: &str, address: &str) -> Finding {
    match connect(address) {
        Ok((_, millis)) => Finding::new(what, Word::Ok, format!("{address} answers within {millis:.1} ms")),
        Err(error) => Finding::new(what, Word::Bad, format!("{address}: {error}")),
    }
}

/// Whether a vehicle may be at an address. Nothing is said to it, so it may be silent too; but what comes from it must be
/// sentences.
fn reach_vehicle(address: &str) -> Finding {
    const WHAT: &str = "vehicle";
    let (mut stream, millis) = match connect(address) {
        Ok(connected) => connected,
        Err(error) => return Finding::new(WHAT, Word::Bad, format!("{address}: {error}")),
    };
    let mut words = [0; 64];
    let heard = stream
        .set_read_timeout(Some(UNASKED))
        .and_then(|()| stream.read(&mut words));
    let said = words.get(..heard.unwrap_or(0)).unwrap_or_default().trim_ascii();
    if said.is_empty() || said.starts_with(b"$") {
        let whether = if said.is_empty() {
            ", and says nothing unasked: whether it is a vehicle shows when a run asks it"
        } else {
            " with sentences"
        };
        let text = format!("{address} answers within {millis:.1} ms{whether}");
        return Finding::new(WHAT, Word::Ok, text);
    }
    let text = format!(
        "{address} is no vehicle: it says `{}`, expected sentences that begin with `$`; is this the right port?",
        said.escape_ascii()
    );
    Finding::new(WHAT, Word::Bad, text)
}

/// A connection, and how long it took, milliseconds.
fn connect(address: &str) -> std::io::Result<(TcpStream, f64)> {
    let clock = Clock::start();
    let stream = resolve(address).and_then(|at| TcpStream::connect_timeout(&at, WITHIN))?;
    Ok((stream, clock.elapsed().as_secs_f64() * 1000.0))
}

fn resolve(address: &str) -> std::io::Result<SocketAddr> {
    let mut found = address.to_socket_addrs()?;
    found.next().ok_or_else(|| std::io::Error::other("has no address"))
}

/// How far another clock is ahead of ours, seconds: a request of a client of version 4 (RFC 5905, section 14).
fn ask_time(address: &str) -> Option<f64> {
    let at = resolve(address).ok()?;
    let local = if at.is_ipv4() { "0.0.0.0:0" } else { "[::]:0" };
    let socket = UdpSocket::bind(local).ok()?;
    socket.set_read_timeout(Some(WITHIN)).ok()?;
    socket.connect(at).ok()?;
    let mut packet = [0u8; 48];
    packet[0] = 0b00_100_011;
    let now_s = || Clock::start().utc_at_start().as_unix_nanos() as f64 / 1e9;
    let left_s = now_s();
    socket.send(&packet).ok()?;
    let length = socket.recv(&mut packet).ok()?;
    let back_s = now_s();
    offset(packet.get(..length)?, left_s, back_s)
}

/// The offset of the clock that has answered, from its answer and the times at which the request left and it came.
fn offset(answer: &[u8], left_s: f64, back_s: f64) -> Option<f64> {
    // A server's answer, of a clock that is set.
    if answer.len() < 48 || answer[0] & 7 != 4 || answer[0] >> 6 == 3 || answer[1] == 0 {
        return None;
    }
    let time = |place: usize| {
        let part = |place: usize| -> Option<f64> {
            Some(f64::from(u32::from_be_bytes(
                answer.get(place..place + 4)?.try_into().ok()?,
            )))
        };
        Some(part(place)? - FROM_1900_S + part(place + 4)? / 4_294_967_296.0)
    };
    let (received_s, sent_s) = (time(32)?, time(40)?);
    Some(((received_s - left_s) + (sent_s - back_s)) / 2.0)
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;
    use std::net::TcpListener;

    use super::*;

    /// An answer of a clock that says these Unix seconds.
    fn answer(unix_s: f64) -> Vec<u8> {
        let mut packet = vec![0u8; 48];
        (packet[0], packet[1]) = (0b00_100_100, 1);
        for place in [32, 40] {
            let seconds = (unix_s + FROM_1900_S).floor();
            packet[place..place + 4].copy_from_slice(&(seconds as u32).to_be_bytes());
            let rest = ((unix_s + FROM_1900_S - seconds) * 4_294_967_296.0) as u32;
            packet[place + 4..place + 8].copy_from_slice(&rest.to_be_bytes());
        }
        packet
    }

    #[test]
    fn an_answer_of_ntp_gives_the_offset_half_way_of_the_trip() {
        let at_s = 1_780_300_800.25;
        let found = offset(&answer(at_s + 3.0), at_s - 0.1, at_s + 0.1).unwrap();
        assert!((found - 3.0).abs() < 1e-5, "{found}");
        assert_eq!(offset(&answer(at_s)[..47], at_s, at_s), None);
        let mut unset = answer(at_s);
        unset[0] |= 0b11_000_000;
        assert_eq!(offset(&unset, at_s, at_s), None);
    }

    /// What is found at the vehicle's address if this is said there.
    fn at_address(says: &'static [u8]) -> Finding {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let vehicle = std::thread::spawn(move || {
            let (mut stream, _) = listener.accept().unwrap();
            stream.write_all(says).unwrap();
            // Until it is closed.
            let _closed = stream.read(&mut [0]);
        });
        let finding = reach_vehicle(&address);
        vehicle.join().unwrap();
        finding
    }

    #[test]
    fn a_program_that_is_no_vehicle_is_told_by_what_it_says() {
        let other = at_address(b"SSH-2.0-OpenSSH_9.2\r\n");
        assert!(
            other.word == Word::Bad && other.text.contains("it says `SSH-2.0-OpenSSH_9.2`"),
            "{other:?}"
        );
        let sentences = at_address(b"\r\n$BFCTL,120000,1*5A\r\n");
        assert!(
            sentences.word == Word::Ok && sentences.text.ends_with("with sentences"),
            "{sentences:?}"
        );
        let silent = at_address(b"");
        assert!(
            silent.word == Word::Ok && silent.text.contains("says nothing unasked"),
            "{silent:?}"
        );
    }

    #[test]
    fn who_listens_is_reached_and_who_does_not_is_not() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        assert_eq!(reach("vehicle", &address).word, Word::Ok);
        drop(listener);
        let finding = reach("vehicle", &address);
        assert!(
            finding.word == Word::Bad && finding.text.contains("refused"),
            "{finding:?}"
        );
        assert_eq!(reach("vehicle", "no.such.host.invalid:1").word, Word::Bad);
    }
}
