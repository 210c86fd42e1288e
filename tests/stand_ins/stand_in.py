"""Message packages that have no wheels, for rclpy and without a compiler.

rclpy asks a message class for five capsules: the type support of the middleware, and functions
that create, fill, read and destroy a message. Here they are functions of Python, called through
ctypes; a message is the CDR bytes that arrived, and rosbags decodes them by the definition. Only
subscriptions work, and only with Fast DDS: that is what a receiver of motion capture needs.

The structures are those of rosidl_runtime_c (rosidl_message_type_support_t) and
rosidl_typesupport_fastrtps_cpp (message_type_support_callbacks_t) of ROS 2 Jazzy.
"""

import ctypes
from ctypes import (  # fmt: skip
    CFUNCTYPE,
    POINTER,
    Structure,
    c_bool,
    c_char_p,
    c_size_t,
    c_uint8,
    c_uint32,
    c_void_p,
    py_object,
)

from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from std_msgs.msg import String

FAST_DDS = b'rosidl_typesupport_fastrtps_c'
INTROSPECTION = b'rosidl_typesupport_introspection_c'
BUFFER = 14
"""Place, in words, of the buffer in an eprosima::fastcdr::Cdr, after seven member functions."""
ENCAPSULATION = b'\x00\x01'
"""How CDR begins: little endian."""

_kept = []
_new_capsule = ctypes.pythonapi.PyCapsule_New
_new_capsule.restype, _new_capsule.argtypes = py_object, [c_void_p, c_char_p, c_void_p]
_pointer_of = ctypes.pythonapi.PyCapsule_GetPointer
_pointer_of.restype, _pointer_of.argtypes = c_void_p, [py_object, c_char_p]
_name_of = ctypes.pythonapi.PyCapsule_GetName
_name_of.restype, _name_of.argtypes = c_char_p, [py_object]


class TypeSupport(Structure):
    _fields_ = (
        ('identifier', c_char_p),
        ('data', c_void_p),
        ('find', c_void_p),
        ('type_hash', c_void_p),
        ('description', c_void_p),
        ('sources', c_void_p),
    )


class Callbacks(Structure):
    _fields_ = (
        ('namespace', c_char_p),
        ('name', c_char_p),
        ('serialize', c_void_p),
        ('deserialize', c_void_p),
        ('serialized_size', c_void_p),
        ('largest_size', c_void_p),
        ('keys', c_void_p),
    )


class TypeHash(Structure):
    _fields_ = (('version', c_uint8), ('value', c_uint8 * 32))


def message_class(message_type, definitions):
    """Return a class of messages that rclpy can subscribe to.

    Args:
        message_type: Such as 'a_msgs/msg/B'.
        definitions: The text of the .msg file of that type, and of those that it needs, by name.
    """
    store = get_typestore(Stores.ROS2_JAZZY)
    types = {}
    for name, text in definitions.items():
        types |= get_types_from_msg(text, name)
    store.register(types)
    functions = _functions(store, message_type)
    support = _type_support(store, message_type, functions['deserialize'])

    class Metaclass(type):
        _CREATE_ROS_MESSAGE = _capsule(functions['create'])
        _CONVERT_FROM_PY = _capsule(functions['create'])  # never called: nothing is published
        _CONVERT_TO_PY = _capsule(functions['to_python'])
        _DESTROY_ROS_MESSAGE = _capsule(functions['destroy'])
        _TYPE_SUPPORT = _capsule(ctypes.pointer(support))

    return Metaclass(message_type.rpartition('/')[2], (), {})


def _functions(store, message_type):
    """Return the functions that rclpy and the middleware call with a message."""
    messages = {}  # the place of a message in memory: a byte of its own, and its CDR bytes

    @CFUNCTYPE(c_void_p)
    def create():
        place = ctypes.create_string_buffer(1)
        messages[ctypes.addressof(place)] = [place, b'']
        return ctypes.addressof(place)

    @CFUNCTYPE(None, c_void_p)
    def destroy(message):
        del messages[message]

    @CFUNCTYPE(c_bool, c_void_p, c_void_p)
    def deserialize(cdr, message):
        buffer = ctypes.cast(cdr, POINTER(c_void_p))[BUFFER]
        _, begin, size = ctypes.cast(buffer, POINTER(c_void_p))[:3]
        messages[message][1] = ctypes.string_at(begin, size)
        assert messages[message][1].startswith(ENCAPSULATION), 'another version of Fast CDR?'
        return True

    @CFUNCTYPE(py_object, c_void_p)
    def to_python(message):
        return store.deserialize_cdr(messages[message][1], message_type)

    return _keep(create=create, destroy=destroy, deserialize=deserialize, to_python=to_python)


def _type_support(store, message_type, deserialize):
    """Return the type support, which borrows from String what concerns no message."""
    package, _, name = message_type.split('/')
    type(String).__import_type_support__()
    capsule = type(String)._TYPE_SUPPORT
    like_pointer = _pointer_of(capsule, _name_of(capsule))
    like = ctypes.cast(like_pointer, POINTER(TypeSupport)).contents
    find_like = CFUNCTYPE(c_void_p, c_void_p, c_char_p)(like.find)
    digest = bytes.fromhex(store.hash_rihs01(message_type).removeprefix('RIHS01_'))
    type_hash = TypeHash(1, (c_uint8 * 32)(*digest))

    @CFUNCTYPE(c_void_p, c_void_p, c_char_p)
    def find(support, identifier):
        if identifier == FAST_DDS:
            return support
        return find_like(like_pointer, identifier) if identifier == INTROSPECTION else None

    @CFUNCTYPE(c_void_p, c_void_p)
    def hash_of(_):
        return ctypes.addressof(type_hash)

    @CFUNCTYPE(c_uint32, c_void_p)
    def serialized_size(_):
        return 0

    @CFUNCTYPE(c_size_t, c_void_p)
    def largest_size(is_bounded):
        ctypes.cast(is_bounded, POINTER(c_uint8))[0] = 0
        return 0

    callbacks = Callbacks(
        f'{package}::msg'.encode(),
        name.encode(),
        None,
        _address(deserialize),
        _address(serialized_size),
        _address(largest_size),
    )
    support = TypeSupport(
        FAST_DDS,
        ctypes.addressof(callbacks),
        _address(find),
        _address(hash_of),
        like.description,
        like.sources,
    )
    _keep(
        find=find,
        find_like=find_like,
        hash_of=hash_of,
        type_hash=type_hash,
        serialized_size=serialized_size,
        largest_size=largest_size,
        callbacks=callbacks,
        support=support,
    )
    return support


def _keep(**things):
    """Keep what the middleware points at; returns it."""
    _kept.append(things)
    return things


def _address(function):
    return ctypes.cast(function, c_void_p).value


def _capsule(pointer):
    return _new_capsule(_address(pointer), None, None)
