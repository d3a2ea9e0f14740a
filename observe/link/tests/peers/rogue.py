"""Peers without credentials against an application that authenticates both ends of every connection.

    rogue.py JDE APPLICATION FOLDER

Runs APPLICATION with `jde run`, listening by TLS and connecting to whatever multicast discovers. Three peers try to stop everything:
one with a valid certificate succeeds, which shows that the request is valid; one that multicast announces without TLS, and one that
connects with a certificate of another authority, must get no reply. FOLDER receives the certificates and the application file.
"""

import datetime
import ipaddress
import json
import socket
import subprocess
import sys
import time
from pathlib import Path

import zenoh
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec

LIMIT = 30.0
STOP = json.dumps({"by": "rogue", "action": "stop-all"})


def write(path, data):
    path.write_bytes(data)
    return str(path)


def authority(folder, name):
    """Creates an authority and a certificate for this machine; returns the paths of both and of the key."""
    now = datetime.datetime.now(datetime.timezone.utc)
    day = datetime.timedelta(days=1)
    issuer, subject = (x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, name + part)]) for part in ("-ca", ""))
    ca_key, key = (ec.generate_private_key(ec.SECP256R1()) for _ in range(2))

    def signed(subject, public, extension, critical):
        builder = x509.CertificateBuilder(issuer, subject, public, x509.random_serial_number())
        builder = builder.not_valid_before(now - day).not_valid_after(now + day).add_extension(extension, critical)
        return builder.sign(ca_key, hashes.SHA256()).public_bytes(serialization.Encoding.PEM)

    alternative_name = x509.SubjectAlternativeName([x509.IPAddress(ipaddress.ip_address("127.0.0.1"))])
    private = key.private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    )
    return {
        "authority": write(folder / f"{name}-ca.pem", signed(issuer, ca_key.public_key(), x509.BasicConstraints(True, None), True)),
        "certificate": write(folder / f"{name}.pem", signed(subject, key.public_key(), alternative_name, False)),
        "key": write(folder / f"{name}.key", private),
    }


def free():
    with socket.socket() as probe:
        probe.bind(("0.0.0.0", 0))
        return probe.getsockname()[1]


def session(**settings):
    config = zenoh.Config()
    for key, value in settings.items():
        config.insert_json5(key.replace("__", "/"), json.dumps(value))
    return zenoh.open(config)


def client(endpoint, trusted, own):
    """Connects by TLS; raises if the application does not admit it."""
    tls = {
        "root_ca_certificate": trusted["authority"],
        "connect_certificate": own["certificate"],
        "connect_private_key": own["key"],
        "enable_mtls": True,
    }
    return session(
        mode="client", connect__endpoints=[endpoint], connect__timeout_ms=2000,
        scouting__multicast__enabled=False, transport__link__tls=tls,
    )


def stops(peer):
    """Whether an application replies that it has stopped everything."""
    replies = peer.get("jde/1/*/*/operate", payload=STOP, timeout=3.0)
    return any(reply.ok is not None for reply in replies)


def until(expected, condition):
    start = time.monotonic()
    while not condition():
        if time.monotonic() - start > LIMIT:
            sys.exit(f"{expected} did not happen within {LIMIT:.0f} s")
        time.sleep(0.1)


def admitted(endpoint, trusted, own):
    try:
        with client(endpoint, trusted, own) as peer:
            return stops(peer)
    except zenoh.ZError:
        return False


def main(jde, application, folder):
    folder = Path(folder)
    trusted, foreign = authority(folder, "trusted"), authority(folder, "foreign")
    port = free()
    endpoint = f"tls/127.0.0.1:{port}"
    announced = session(
        mode="peer", listen__endpoints=[f"tcp/0.0.0.0:{free()}"], scouting__multicast__enabled=True,
    )
    file = folder / "authenticated.toml"
    tls = ", ".join(f"{key} = {json.dumps(path)}" for key, path in trusted.items())
    link = f"[link]\nlisten = ['tls/0.0.0.0:{port}']\ndiscover = true\ntls = {{ {tls} }}\n"
    file.write_text(f"{Path(application).read_text()}\n{link}")
    robot = subprocess.Popen([jde, "run", "--plain", file], stdout=subprocess.DEVNULL, stdin=subprocess.DEVNULL)
    try:
        until("a stop by a peer of the authority", lambda: admitted(endpoint, trusted, trusted))
        if admitted(endpoint, trusted, foreign):
            sys.exit("a peer of another authority stopped the application")
        # It was announced before the application began to discover.
        if stops(announced) or announced.info.peers_zid():
            sys.exit("the application connected to a peer without a certificate")
        if robot.poll() is not None:
            sys.exit("`jde run` ended early")
    finally:
        robot.terminate()
        robot.wait()
        announced.close()
    print("only a peer with a certificate of the authority can stop everything")


if __name__ == "__main__":
    main(*sys.argv[1:])
