"""The types of OPC UA for Devices (OPC 10000-100) that those for Robotics are made from.

Names, numbers, rules and data types are those of the OPC Foundation's own NodeSet (`Opc.Ua.Di`, MIT
licence 1.00); `tables.py` says how to read the lines.
"""

DEVICE_SET = 5001
"""The object in which devices are found."""

TYPES = """
1005 FunctionalGroupType < ua:61
  6027 di:<GroupIdentifier> OP di:1005
15035 IVendorNameplateType < ua:17602 abstract
  15036 di:Manufacturer O Property LocalizedText
  15037 di:ManufacturerUri O Property String
  15038 di:Model O Property LocalizedText
  15039 di:HardwareRevision O Property String
  15040 di:SoftwareRevision O Property String
  15041 di:DeviceRevision O Property String
  15042 di:ProductCode O Property String
  15043 di:DeviceManual O Property String
  15044 di:DeviceClass O Property String
  15045 di:SerialNumber O Property String
  15046 di:ProductInstanceUri O Property String
  15047 di:RevisionCounter O Property Int32
  23 di:SoftwareReleaseDate O Property DateTime
15048 ITagNameplateType < ua:17602 abstract
  15049 di:AssetId O Property String
  15050 di:ComponentName O Property LocalizedText
1001 TopologyElementType < ua:58 abstract
  5002 di:ParameterSet O Object
    6017 di:<ParameterIdentifier> MP Data ua:24
  5003 di:MethodSet O Object
  6567 di:<GroupIdentifier> OP di:1005
  6014 di:Identification O di:1005
15063 ComponentType < di:1001 abstract
  15086 di:Manufacturer O Property LocalizedText
  15087 di:ManufacturerUri O Property String
  15088 di:Model O Property LocalizedText
  15089 di:HardwareRevision O Property String
  15090 di:SoftwareRevision O Property String
  15091 di:DeviceRevision O Property String
  15092 di:ProductCode O Property String
  15093 di:DeviceManual O Property String
  15094 di:DeviceClass O Property String
  15095 di:SerialNumber O Property String
  15096 di:ProductInstanceUri O Property String
  15097 di:RevisionCounter O Property Int32
  15098 di:AssetId O Property String
  15099 di:ComponentName O Property LocalizedText
  implements di:15035
  implements di:15048
15106 SoftwareType < di:15063
  15129 di:Manufacturer M Property LocalizedText
  15131 di:Model M Property LocalizedText
  15133 di:SoftwareRevision M Property String
"""
