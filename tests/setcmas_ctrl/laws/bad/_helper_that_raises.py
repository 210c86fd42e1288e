def value_of(name):
    return {}[name]
