//! Which client gets which role, and what the vehicle sends to a role (SPI 4.1, 5.1).

use std::net::SocketAddr;

use backseat_mvc::{ClientId, Mvc, RoleConfig, WithoutRole, WorldFile};

use crate::files::CALM;
use crate::payload::Payload;

const ONE: ClientId = ClientId(1);
const TWO: ClientId = ClientId(2);
const THREE: ClientId = ClientId(3);

fn vehicle(roles: &str, without_role: WithoutRole) -> Payload {
    let mut file = WorldFile::from_toml(CALM).expect("the calm world is right");
    file.spi.roles = RoleConfig::list(roles).expect("the test's roles are right");
    file.spi.without_role = without_role;
    Payload::of(Mvc::new(&file, 1).expect("the test's world is possible"))
}

fn address(text: &str) -> Option<SocketAddr> {
    Some(text.parse().expect("the test's address is one"))
}

#[test]
fn the_pattern_with_the_port_wins_at_any_place_of_the_list() {
    // SPI 4.1: "if a client connects using port 12345, it gets the role bar, otherwise it gets the role foo; or, two
    // clients may be connected".
    for roles in [
        "127.0.0.1::foo,127.0.0.1:12345:bar",
        "127.0.0.1:12345:bar,127.0.0.1::foo",
    ] {
        let mut payload = vehicle(roles, WithoutRole::Refuse);
        payload.connect_from(ONE, address("127.0.0.1:12345"));
        payload.connect_from(TWO, address("127.0.0.1:40000"));
        assert_eq!(payload.mvc.role(ONE), Some("bar"));
        assert_eq!(payload.mvc.role(TWO), Some("foo"));
        // Both roles are taken: a third client whose address fits is turned away.
        payload.connect_from(THREE, address("127.0.0.1:40001"));
        assert_eq!(payload.cut_off, [THREE]);
        assert!(
            payload
                .log()
                .iter()
                .any(|line| line.ends_with("client 3 cut off: another client holds its role")),
            "{roles}"
        );
    }
}

#[test]
fn a_client_whose_own_role_is_taken_gets_the_general_one() {
    let mut payload = vehicle("127.0.0.1::foo,127.0.0.1:12345:bar,10.0.0.7::bar", WithoutRole::Refuse);
    payload.connect_from(ONE, address("10.0.0.7:1"));
    payload.connect_from(TWO, address("127.0.0.1:12345"));
    assert_eq!(payload.mvc.role(ONE), Some("bar"));
    assert_eq!(payload.mvc.role(TWO), Some("foo"));
}

#[test]
fn a_role_belongs_to_one_client_and_is_free_when_that_has_disconnected() {
    // SPI 4.1: "The above example only allows a single connection, since only one role is defined. But, if one payload
    // disconnects, a different one can connect and use the now released role."
    let mut payload = vehicle("127.0.0.1:12345:foo,192.168.10.10::foo", WithoutRole::Refuse);
    payload.connect_from(ONE, address("127.0.0.1:12345"));
    payload.connect_from(TWO, address("192.168.10.10:7"));
    assert_eq!(payload.cut_off, [TWO]);
    assert_eq!(payload.heard_by(TWO), Vec::<String>::new());
    payload.mvc.disconnect(payload.now, ONE);
    payload.connect_from(THREE, address("192.168.10.10:8"));
    assert_eq!(payload.mvc.role(THREE), Some("foo"));
    assert_eq!(payload.heard_by(THREE), ["$BFVER,080000.000,1.12"]);
    let log = payload.log();
    for line in [
        "client 1 has the role foo",
        "the role foo of client 1 is free",
        "client 3 has the role foo",
    ] {
        assert!(log.iter().any(|logged| logged.ends_with(line)), "{line}: {log:?}");
    }
}

#[test]
fn a_client_that_is_cut_off_gives_its_role_back() {
    let mut payload = vehicle("127.0.0.1::foo", WithoutRole::Refuse);
    payload.connect_from(ONE, address("127.0.0.1:1"));
    // The client never reads the answers.
    let flood = "$BPLOG,ACK,ON\r\n$BPMSG,070000.000,x\r\n".repeat(60_000);
    payload.mvc.receive(payload.now, ONE, flood.as_bytes());
    payload.connect_from(TWO, address("127.0.0.1:2"));
    assert_eq!(payload.mvc.role(TWO), Some("foo"));
}

#[test]
fn clients_without_a_role_are_turned_away_or_served_as_the_setting_says() {
    let mut payload = vehicle("192.168.10.10::foo", WithoutRole::Refuse);
    payload.connect_from(ONE, address("127.0.0.1:1"));
    assert_eq!(payload.cut_off, [ONE]);
    assert!(
        payload
            .log()
            .iter()
            .any(|line| line.ends_with("its address has no role"))
    );

    let mut payload = vehicle("192.168.10.10::foo", WithoutRole::Accept);
    payload.connect_from(ONE, address("127.0.0.1:1"));
    payload.connect_from(TWO, address("127.0.0.1:2"));
    assert_eq!(payload.cut_off, []);
    assert_eq!(payload.mvc.role(ONE), None);
    assert_eq!(payload.heard_by(TWO).len(), 1);
}

#[test]
fn without_roles_everybody_is_served() {
    let mut payload = Payload::new(CALM, 1);
    payload.connect_from(ONE, address("127.0.0.1:1"));
    payload.connect_from(TWO, None);
    assert_eq!((payload.heard_by(ONE).len(), payload.heard_by(TWO).len()), (1, 1));
}

/// SPI 5.1: BFMSC from the file.
#[test]
fn a_mission_command_goes_to_the_role_or_to_all() {
    let text = CALM.replace(
        "[mission]",
        r#"[[spi.roles]]
address = "127.0.0.1"
port = 1
role = "sonar"
[[spi.roles]]
address = "127.0.0.1"
role = "other"
[[mission.commands]]
at_s = 5
text = "all together"
[[mission.commands]]
at_s = 2.5
role = "sonar"
text = "start line 3"
[[mission.commands]]
at_s = 6
role = "camera"
text = "look"
[mission]"#,
    );
    // In this file `[spi]` comes after its own roles, as TOML allows.
    let mut payload = Payload::new(&text, 1);
    payload.connect_from(ONE, address("127.0.0.1:1"));
    payload.connect_from(TWO, address("127.0.0.1:2"));
    payload.heard_by(ONE);
    payload.heard_by(TWO);
    // The mission starts at 1 s: just before, and just after.
    payload.until(3.45);
    assert_eq!(payload.heard_by(ONE), Vec::<String>::new());
    payload.until(3.55);
    assert_eq!(payload.heard_by(ONE), ["$BFMSC,080003.500,start line 3"]);
    payload.until(10.0);
    assert_eq!(payload.heard_by(ONE), ["$BFMSC,080006.000,all together"]);
    assert_eq!(payload.heard_by(TWO), ["$BFMSC,080006.000,all together"]);
    let log = payload.log();
    assert!(
        log.iter()
            .any(|line| line.ends_with("BFMSC is for the role camera, which no client holds")),
        "{log:?}"
    );
}

#[test]
fn roles_and_mission_commands_of_the_file_are_checked() {
    let roles = |lines: &str| format!("{CALM}\n[[spi.roles]]\n{lines}");
    let commands = |lines: &str| format!("{CALM}\n[[mission.commands]]\n{lines}");
    for (text, told) in [
        (roles("address = \"localhost\"\nrole = \"a\""), "address"),
        (roles("address = \"::1\"\nrole = \"a b\""), "spi.roles.role"),
        (
            roles("address = \"::1\"\nrole = \"a\"\nname = 1"),
            "unknown field `name`",
        ),
        (commands("at_s = -1\ntext = \"x\""), "mission.commands.at_s is -1"),
        (commands("at_s = 1\ntext = \"a,b\""), "mission.commands.text"),
        (commands("at_s = 1\ntext = \"\""), "mission.commands.text"),
        (
            CALM.replace("[spi]", "[spi]\nclients_max = 257"),
            "spi.clients_max is 257, expected 1 to 256",
        ),
    ] {
        let message = WorldFile::from_toml(&text).unwrap_err().to_string();
        assert!(message.contains(told), "{message}");
    }
}
