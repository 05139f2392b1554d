//! Tool path to axis path: branch over the whole path, unwinding, singular cone.
