"""The types of OPC UA for Robotics (OPC 40010-1, version 1.02) that a bin picking cell needs.

Names, numbers, rules and data types are those of the OPC Foundation's own NodeSet
(`Opc.Ua.Robotics`, MIT licence 1.00); `tables.py` says how to read the lines.  Left out are the
state machines and programs of version 1.02, which are all optional: the server says that it holds
a subset.
"""

ENUMERATIONS = {
    3008: (
        "AxisMotionProfileEnumeration",
        6027,
        ("OTHER", "ROTARY", "ROTARY_ENDLESS", "LINEAR", "LINEAR_ENDLESS"),
    ),
    18191: ("ExecutionModeEnumeration", 18192, ("CYCLE", "CONTINUOUS", "STEP")),
    18193: (
        "MotionDeviceCategoryEnumeration",
        18194,
        (
            "OTHER",
            "ARTICULATED_ROBOT",
            "SCARA_ROBOT",
            "CARTESIAN_ROBOT",
            "SPHERICAL_ROBOT",
            "PARALLEL_ROBOT",
            "CYLINDRICAL_ROBOT",
        ),
    ),
    3006: (
        "OperationalModeEnumeration",
        6022,
        (
            "OTHER",
            "MANUAL_REDUCED_SPEED",
            "MANUAL_HIGH_SPEED",
            "AUTOMATIC",
            "AUTOMATIC_EXTERNAL",
        ),
    ),
}
"""By number: name, number of its property EnumStrings, and what 0, 1, 2 ... mean."""

REFERENCES = {
    4002: ("Controls", "IsControlledBy", 33),
    18182: ("HasSafetyStates", "SafetyStatesOf", 33),
    18183: ("HasSlave", "IsSlaveOf", 33),
    18180: ("IsDrivenBy", "Drives", 33),
    18178: ("Moves", "IsMovedBy", 33),
    18179: ("Requires", "IsRequiredBy", 33),
    18181: ("IsConnectedTo", "IsConnectedTo", 32),
}
"""Types of references by number: name, the name the other way round, and what it is a kind of."""

TYPES = """
1002 MotionDeviceSystemType < di:15063
  6171 di:ComponentName O Property LocalizedText
  5001 Controllers M Folder
    15405 <ControllerIdentifier> MP rob:1003
  5002 MotionDevices M Folder
    15008 <MotionDeviceIdentifier> MP rob:1004
  5010 SafetyStates M Folder
    15697 <SafetyStateIdentifier> MP rob:1013
1003 ControllerType < di:15063
  18964 <MotionDeviceIdentifier> OP rob:1004 Controls
  18918 <SafetyStatesIdentifier> OP rob:1013 HasSafetyStates
  6180 di:AssetId O Property String
  6181 di:ComponentName O Property LocalizedText
  17252 Components O Folder
    18813 <ComponentIdentifier> MP di:15063
  17249 CurrentUser M rob:18175
    17250 Level M Property String
  6182 di:DeviceManual O Property String
  17237 di:Manufacturer M Property LocalizedText
  17239 di:Model M Property LocalizedText
  17245 di:ProductCode M Property String
  17240 di:SerialNumber M Property String
  15800 Software M Folder
    18847 <SoftwareIdentifier> MP di:15106
  15826 TaskControls M Folder
    18881 <TaskControlIdentifier> MP rob:1011
1004 MotionDeviceType < di:15063
  16566 AdditionalComponents O Folder
    5003 <AdditionalComponentIdentifier> MP Object
  6172 di:AssetId O Property String
  15305 Axes M Folder
    15743 <AxisIdentifier> MP rob:16601
  6173 di:ComponentName O Property LocalizedText
  6174 di:DeviceManual O Property String
  16351 di:Manufacturer M Property LocalizedText
  16353 di:Model M Property LocalizedText
  16362 MotionDeviceCategory M Property MotionDeviceCategoryEnumeration
  5029 di:ParameterSet M Object
    16364 InControl O Data Boolean
    16363 OnPath O Data Boolean
    16365 SpeedOverride M Data Double
  16443 PowerTrains M Folder
    15905 <PowerTrainIdentifier> MP rob:16794
  16359 di:ProductCode M Property String
  16354 di:SerialNumber M Property String
  6001 TaskControlReference O Data NodeId
16601 AxisType < di:15063
  18344 <PowerTrainIdentifier> OP rob:16794 Requires
  6175 di:AssetId O Property String
  16637 MotionProfile M Property AxisMotionProfileEnumeration
  16602 di:ParameterSet M Object
    16674 ActualAcceleration O Analog Double
      16679 ua:EngineeringUnits M Property EUInformation
    16662 ActualPosition M Analog Double
      16667 ua:EngineeringUnits M Property EUInformation
    16668 ActualSpeed O Analog Double
      16673 ua:EngineeringUnits M Property EUInformation
16794 PowerTrainType < di:15063
  18536 <AxisIdentifier> OP rob:16601 Moves
  16041 <GearIdentifier> OP rob:1022
  15998 <MotorIdentifier> MP rob:1019
  18613 <PowerTrainIdentifier> OP rob:16794 HasSlave
  6176 di:ComponentName O Property LocalizedText
1019 MotorType < di:15063
  5060 <DriveIdentifier> OP Object IsDrivenBy
  6177 di:AssetId O Property String
  17101 di:Manufacturer M Property LocalizedText
  17103 di:Model M Property LocalizedText
  5105 di:ParameterSet M Object
    17150 BrakeReleased O Data Boolean
    6776 EffectiveLoadRate O Data UInt16
    6757 MotorTemperature M Analog Double
      6762 ua:EngineeringUnits M Property EUInformation
  17109 di:ProductCode M Property String
  17104 di:SerialNumber M Property String
1022 GearType < di:15063
  6178 di:AssetId O Property String
  15941 GearRatio M Rational RationalNumber
    15616 ua:Denominator M Data UInt32
    15615 ua:Numerator M Data Int32
  17152 di:Manufacturer M Property LocalizedText
  17154 di:Model M Property LocalizedText
  17165 Pitch O Data Double
  17160 di:ProductCode M Property String
  17155 di:SerialNumber M Property String
1013 SafetyStateType < di:15063
  6179 di:ComponentName O Property LocalizedText
  17221 EmergencyStopFunctions O Folder
    18806 <EmergencyStopFunctionIdentifier> MP rob:17230
  5016 di:ParameterSet M Object
    15882 EmergencyStop M Data Boolean
    15912 OperationalMode M Data OperationalModeEnumeration
    15913 ProtectiveStop M Data Boolean
  17225 ProtectiveStopFunctions O Folder
    18809 <ProtectiveStopFunctionIdentifier> MP rob:17233
17230 EmergencyStopFunctionType < ua:58
  17232 Active M Data Boolean
  17231 Name M Property String
17233 ProtectiveStopFunctionType < ua:58
  17236 Active M Data Boolean
  17235 Enabled M Data Boolean
  17234 Name M Property String
1011 TaskControlType < di:15063
  19254 <MotionDeviceIdentifier> OP rob:1004 Controls
  17873 di:ComponentName M Property LocalizedText
  15883 di:ParameterSet M Object
    17876 ExecutionMode O Data ExecutionModeEnumeration
    17875 TaskProgramLoaded M Data Boolean
    17874 TaskProgramName M Data String
18175 UserType < ua:58
  18176 Level M Property String
  18177 Name O Property String
"""
